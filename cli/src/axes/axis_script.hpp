#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/axes/axis_door.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// Requests to axes, one after the other:
///
///     x move 90deg velocity=30deg/s   asks for it, and goes on at once
///     wait x                          until x has done, or reached, what it was last asked for; `wait all`
///     sleep 0.5s
///     # a remark
///
/// At the end it waits for all.
class AxisScript {
 public:
  /// Reads a script for these axes. Failure (status 2): file, line and what was expected.
  [[nodiscard]] static Outcome<AxisScript> read(const std::filesystem::path& file,
                                                std::span<const ecat_master::AxisConfig> axes);
  /// The same for text that is at hand.
  [[nodiscard]] static Outcome<AxisScript> parse(std::string_view text, const std::string& name,
                                                 std::span<const ecat_master::AxisConfig> axes);

  /// Goes on as far as possible; `now` is the time of the line. True: it is done. Failure: a request was refused or has
  /// failed.
  [[nodiscard]] Outcome<bool> step(runtime::AxisDoor& door, std::chrono::nanoseconds now);

 private:
  /// A line of the script.
  struct Step {
    enum class Kind : std::uint8_t { kRequest, kWait, kSleep };
    Kind kind = Kind::kRequest;
    std::size_t line = 0;
    std::vector<std::size_t> axes{};
    std::vector<ecat_master::AxisRequest> requests{};  ///< of these axes
    std::chrono::nanoseconds time{};
  };
  /// A request that has been made.
  struct Made {
    std::size_t line = 0;
    std::size_t axis = 0;
    std::uint64_t number = 0;
    bool last = true;  ///< there is no later one to this axis
    bool over = false;
  };

  explicit AxisScript(std::string name) : name_(std::move(name)) {}
  [[nodiscard]] static Outcome<Step> read_step(std::span<const std::string> words,
                                               std::span<const ecat_master::AxisConfig> axes);
  [[nodiscard]] Outcome<void> ask(runtime::AxisDoor& door, const Step& step);
  [[nodiscard]] Outcome<void> look_at_requests(const runtime::AxisDoor& door);
  [[nodiscard]] Outcome<bool> done(runtime::AxisDoor& door, const Step& step, std::chrono::nanoseconds now);
  [[nodiscard]] bool arrived(std::span<const std::size_t> axes) const;
  [[nodiscard]] tl::unexpected<Failure> fail(std::size_t line, const std::string& reason) const;

  std::string name_;
  std::vector<Step> steps_;
  std::size_t next_ = 0;
  bool begun_ = false;
  std::chrono::nanoseconds step_began_{};
  bool step_runs_ = false;
  std::vector<Made> made_;
};

}  // namespace driveline::cli
