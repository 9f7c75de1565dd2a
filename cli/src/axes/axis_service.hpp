#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "axes/command_sender.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/config/coupling_config.hpp"

namespace driveline::cli {

/// Answers the commands of clients at the control socket that start with the word "axis", one line of JSON each:
///
///     x move 90deg velocity=30deg/s  requests a motion of axis x; "all" instead of the name: of all axes
///     x move 90deg take-over         also if another caller commands the axis
///     progress                       progress of the last request to each axis, whether the axis has accepted it, and
///                                    why it failed; also a sign of life of the client
///     x status                       state of the axis
///     x release                      releases the axis
///     detach                         the requests continue when the connection ends
///
/// A client owns the axes that it commands as long as it is connected and sends something at least every kKeepAlive.
/// Axes that it moves are stopped when it disconnects, unless it has detached. Belongs to the thread of the socket.
class AxisService {
 public:
  /// Longest time between two commands of a client.
  static constexpr std::chrono::milliseconds kKeepAlive{500};

  /// `axis_requests` must outlive this object. `couplings`: gears and cams of its axes.
  explicit AxisService(runtime::AxisRequests& axis_requests, runtime::CouplingPlan couplings = {})
      : axis_requests_(axis_requests), couplings_(std::move(couplings)) {}

  /// Executes a command and returns the answer; {"error": sentence, "status": 1 or 2} on failure.
  [[nodiscard]] std::string execute(const CommandSender& sender, std::string_view words);
  /// Handles the end of a connection: releases the axes of its client.
  void disconnected(const CommandSender& sender);
  /// Notes that a connection was refused, because its process belongs to another user.
  void refused(const CommandSender& sender);
  /// Supervises the clients. To be called every few milliseconds.
  void watch() { axis_requests_.watch(); }

 private:
  /// The requests of a client.
  struct Client {
    runtime::AxisCaller caller;
    std::map<std::size_t, std::uint64_t> requests;  ///< number of the last request to each axis
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

  runtime::AxisRequests& axis_requests_;
  runtime::CouplingPlan couplings_;
  std::map<std::uint64_t, Client> clients_;  ///< by number of the connection
};

}  // namespace driveline::cli
