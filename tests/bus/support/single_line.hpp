#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "demand_judge.hpp"
#include "drive_line.hpp"
#include "fault_ports.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {

using motion::AxisCommand;
using motion::AxisError;
using motion::AxisRequest;
using motion::BufferMode;
using motion::PlcopenState;
using motion::RequestPhase;
using motion::RequestReport;

inline constexpr nanoseconds kSinglePeriod = microseconds{125};
inline AxisRequest request(AxisCommand command, double target = 0.0, double velocity = 0.0) {
  AxisRequest made;
  made.command = command;
  made.target_si = target;
  made.velocity_si = velocity;
  return made;
}

inline AxisRequest power(bool on) {
  AxisRequest made = request(AxisCommand::kPower);
  made.on = on;
  return made;
}

inline AxisRequest move(double target, double velocity = 0.0, BufferMode buffer = BufferMode::kAborting) {
  auto made = request(AxisCommand::kMoveAbsolute, target, velocity);
  made.buffer = buffer;
  return made;
}

/// Options with which the drives' own quick stops brake no harder than the limits of the axes.
inline RunOptions single_options() {
  RunOptions options;
  options.single_axes = true;
  limit_quick_stops(options);
  return options;
}

/// A line in OP whose axes are commanded individually; the test can lose its frames.
class SingleLine {
 public:
  explicit SingleLine(std::size_t axes = 1, const RunOptions& options = single_options(),
                      const std::vector<slaves::msd::MachineSwitch>& switches = {}, double first_position_rad = 0.0)
      : drives(axes, {}, {}, std::nullopt, options.variant, first_position_rad, switches),
        outwards(drives.line(), LossyPort::Direction::kOut, [this](auto, auto) { return lose_out; }),
        port(outwards, LossyPort::Direction::kBack, [this](auto, auto) { return lose_back; }),
        operation(drives, port, options) {
    const double range = options.range_min < options.range_max
                             ? static_cast<double>(options.range_max) - options.range_min + 1.0
                             : 4294967296.0;
    for (std::size_t i = 0; i < axes; ++i) judges.emplace_back(drives, i, demand_limits(options), range);
    EXPECT_EQ(sentence(operation.to_op()), "");
    cycles(100);
  }

  /// Limits of the drives' demands; a compensation leaves less of them to the axes.
  [[nodiscard]] static trajectory::AxisLimits demand_limits(RunOptions options) {
    options.compensation = nullptr;
    return LineOperation::axis(0, options).limits;
  }

  [[nodiscard]] motion::SingleAxes& axes() noexcept { return operation.single_axes(); }
  [[nodiscard]] PlcopenState state(std::size_t axis = 0) noexcept { return axes().axis_report(axis).state; }
  [[nodiscard]] double setpoint(std::size_t axis = 0) noexcept { return axes().axis_report(axis).setpoint; }
  [[nodiscard]] RequestPhase phase(std::uint64_t id) noexcept { return axes().report(id).phase; }

  /// Advances to a fixed point in the period at which neither a control step of the drives nor a frame is due.
  void settle() {
    const auto place = drives.clock.now() / kSinglePeriod * kSinglePeriod + microseconds{110};
    drives.leave_alone(std::max(place - drives.clock.now(), nanoseconds{0}));
  }
  void cycle() {
    operation.cycle();
    settle();
    look();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// Lets `periods` pass without a cycle.
  void stall(int periods) {
    for (int i = 0; i < periods; ++i) {
      drives.leave_alone(kSinglePeriod);
      look();
    }
    drives.leave_alone(microseconds{15});
    cycle();
  }
  std::uint64_t submit(const AxisRequest& asked, std::size_t axis = 0) { return axes().submit(axis, asked); }
  /// Runs cycles until the request is over, or `at_most` cycles (one second).
  RequestReport finish(std::uint64_t id, int at_most = 8000) {
    for (int i = 0; i < at_most && !axes().report(id).over(); ++i) cycle();
    return axes().report(id);
  }
  RequestReport ask(const AxisRequest& asked, std::size_t axis = 0) { return finish(submit(asked, axis)); }
  void enable(std::size_t axis = 0) {
    ASSERT_EQ(ask(power(true), axis).phase, RequestPhase::kDone);
    // A coasting axis is braked first.
    for (int i = 0; i < 4000 && state(axis) == PlcopenState::kDiscreteMotion; ++i) cycle();
    ASSERT_EQ(state(axis), PlcopenState::kStandstill);
  }
  void expect_obedience() const {
    for (const auto& judge : judges) judge.expect_obedience();
  }

  void look() {
    for (auto& judge : judges) judge.look();
    if (each_period) each_period();
  }

  std::function<void()> each_period{};  ///< called in each period, also without a cycle
  bool lose_out = false;
  bool lose_back = false;
  DriveLine drives;
  LossyPort outwards;
  LossyPort port;
  LineOperation operation;
  std::vector<DemandJudge> judges;
};

/// Runs cycles whose frames are lost on their way to the drives.
template <typename Line>
void lose_outputs(Line& line, int count) {
  line.lose_out = true;
  line.cycles(count);
  line.lose_out = false;
}
/// The same on their way back.
template <typename Line>
void lose_inputs(Line& line, int count) {
  line.lose_back = true;
  line.cycles(count);
  line.lose_back = false;
}

/// A line whose first axis is enabled.
template <typename Line>
struct Enabled : Line {
  using Line::Line;
  bool enabled = (this->enable(), true);
};

}  // namespace driveline::bus_test
