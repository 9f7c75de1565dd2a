#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "axes/command_sender.hpp"
#include "driveline/runtime/axes/axis_door.hpp"
#include "driveline/runtime/config/coupling_config.hpp"

namespace driveline::cli {

/// Answers what clients at the control socket say behind the word "axis", one line of JSON each:
///
///     x move 90deg velocity=30deg/s    asks for a motion of axis x; "all" in its place asks all axes
///     x move 90deg take-over           also if somebody else commands the axis
///     progress                         how far the last request to each axis is; says that the client is there
///     x status                         what the axis does
///     x release                        gives the axis back
///     detach                           the requests go on when the connection ends
///
/// A client has the axes that he asks something of as long as he is connected and says something at least every
/// kKeepAlive. The axes that he moves stop when he goes, unless he has detached. Belongs to the thread of the socket.
class AxisService {
 public:
  /// How long a client may be silent.
  static constexpr std::chrono::milliseconds kKeepAlive{500};

  /// `door` must outlive it. `couplings`: gears and cams of its axes.
  explicit AxisService(runtime::AxisDoor& door, runtime::CouplingPlan couplings = {})
      : door_(door), couplings_(std::move(couplings)) {}

  /// The answer; {"error": sentence, "status": 1 or 2} when it cannot be done.
  [[nodiscard]] std::string execute(const CommandSender& sender, std::string_view words);
  /// The connection has ended.
  void gone(const CommandSender& sender);
  /// Somebody was not let in.
  void refused(const CommandSender& sender);
  /// To be called every few milliseconds.
  void watch() { door_.watch(); }

 private:
  /// What a client has asked for.
  struct Client {
    runtime::AxisCaller caller;
    std::map<std::size_t, std::uint64_t> requests;  ///< the last one of each axis
    bool detached = false;
  };

  [[nodiscard]] nlohmann::json answer(Client& client, std::vector<std::string> words);
  [[nodiscard]] nlohmann::json order(Client& client, const std::vector<std::size_t>& axes,
                                     std::vector<std::string> words);
  [[nodiscard]] nlohmann::json couple(Client& client, const runtime::AxisCaller& caller,
                                      const std::vector<std::size_t>& axes, const std::vector<std::string>& words);
  [[nodiscard]] nlohmann::json progress(const Client& client) const;
  [[nodiscard]] nlohmann::json status(const std::vector<std::size_t>& axes) const;
  [[nodiscard]] std::string failure_of(const Client& client, std::size_t axis,
                                       const runtime::AxisProgress& progress) const;

  runtime::AxisDoor& door_;
  runtime::CouplingPlan couplings_;
  std::map<std::uint64_t, Client> clients_;  ///< by connection
};

}  // namespace driveline::cli
