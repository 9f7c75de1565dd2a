#include "driveline/motion/control/position_watch.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::motion {
namespace {

/// A drive may overshoot, and may exceed the velocity of its axis while it catches up after late setpoints.
constexpr double kOvershootFactor = 2.0;
/// Smallest motion of the setpoint that an axis must follow, in increments: an encoder may be coarse.
constexpr double kIncrements = 16.0;

double seconds_of(std::chrono::nanoseconds time) noexcept {
  return std::chrono::duration<double>(time).count();
}

double tolerance_of(const AxisConfig& axis) noexcept {
  const double tolerance = position_tolerance(axis);
  return tolerance > 0.0 ? std::max(tolerance, kIncrements / axis.increments_per_unit) : 0.0;
}

}  // namespace

PositionWatch::PositionWatch(const AxisConfig& axis, std::chrono::nanoseconds period) noexcept
    : max_velocity_(axis.limits.max_velocity), tolerance_(tolerance_of(axis)), cycle_s_(seconds_of(period)) {}

void PositionWatch::forget() noexcept {
  known_ = false;
  steady_ = false;
  driven_ = false;
  unsteady_ = {};
}

void PositionWatch::begin(std::int64_t cycle, double position) noexcept {
  known_ = true;
  steady_ = false;
  plausible_ = 0;
  begin_ = last_cycle_ = change_cycle_ = cycle;
  last_ = held_ = position;
}

PositionFinding PositionWatch::judge(std::int64_t cycle, double position, const trajectory::AxisSetpoint& setpoint,
                                     bool driven, std::chrono::nanoseconds took) noexcept {
  if (!known_) {
    begin(cycle, position);
    setpoint_at_change_ = setpoint.position;
    return {};
  }
  const double held_up = std::max(seconds_of(took) - cycle_s_, 0.0);
  auto finding = step(position, setpoint, seconds(std::max<std::int64_t>(cycle - last_cycle_, 1)) + held_up);
  settle(cycle, position, finding);
  if (finding && driven && !driven_) {
    finding.kind = PositionFinding::Kind::kNewPlace;
    held_ = position;
  }
  // The time for kFrozen starts anew when the axis starts to be driven.
  if (std::abs(position - last_) > 0.0 || driven != driven_) {
    change_cycle_ = cycle;
    setpoint_at_change_ = setpoint.position;
  }
  if (finding.kind == PositionFinding::Kind::kNewPlace) setpoint_at_change_ = position;
  driven_ = driven;
  last_ = position;
  last_cycle_ = cycle;
  if (!driven || tolerance_ <= 0.0) return {};
  return finding.kind != PositionFinding::Kind::kNone ? finding : standstill(cycle, setpoint);
}

PositionFinding PositionWatch::step(double position, const trajectory::AxisSetpoint& setpoint,
                                    double within) const noexcept {
  // A drive that measures less often than once per cycle catches up in one step.
  const double owed = std::abs(setpoint.position - setpoint_at_change_);
  // The time of an answer varies within its cycle: two positions may be up to a cycle further apart.
  const double distance =
      std::max(std::max(max_velocity_, std::abs(setpoint.velocity)) * (within + cycle_s_), driven_ ? owed : 0.0);
  const double allowed = kOvershootFactor * distance + tolerance_;
  const double moved = position - last_;
  if (std::abs(moved) <= allowed) return {};
  return {PositionFinding::Kind::kLeap, last_, moved, allowed, within};
}

PositionFinding PositionWatch::standstill(std::int64_t cycle, const trajectory::AxisSetpoint& setpoint) const noexcept {
  const double stood = seconds(cycle - change_cycle_);
  const double sent = setpoint.position - setpoint_at_change_;
  if (stood < seconds_of(kFrozenTime) || std::abs(sent) <= tolerance_) return {};
  return {PositionFinding::Kind::kFrozen, last_, sent, tolerance_, stood};
}

/// Updates the position at which the axis can be enabled.
void PositionWatch::settle(std::int64_t cycle, double position, const PositionFinding& finding) noexcept {
  if (finding && tolerance_ > 0.0) {
    unsteady_ = finding;
    steady_ = false;
    plausible_ = 0;
    begin_ = cycle;
    return;
  }
  if (!steady_) {
    ++plausible_;
    steady_ = plausible_ >= kSteadyExchanges && seconds(cycle - begin_) >= seconds_of(kSteadyTime);
  }
  if (!steady_) return;
  held_ = position;
  if (unsteady_) unsteady_ = {};
}

}  // namespace driveline::motion
