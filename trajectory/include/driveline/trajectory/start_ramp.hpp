#pragma once

#include <optional>

#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Moves one axis smoothly from standstill at one position to standstill at another: a polynomial of fifth degree in
/// time with zero velocity and acceleration at both ends (minimum jerk). Used to approach the first point of a path. A
/// plain value without heap memory.
class StartRamp {
 public:
  /// Plans the shortest ramp that keeps the limits, which must be positive and finite. nullopt if an argument or the
  /// duration is not finite or a limit is not positive. \rtsafe
  [[nodiscard]] static std::optional<StartRamp> plan(double from, double to, const AxisLimits& limits) noexcept;

  /// Lengthens the ramp, so that several axes arrive together; a shorter duration or NaN changes nothing. \rtsafe
  void stretch_to(double duration_s) noexcept;

  /// Returns the setpoint at a time after the ramp's start: before it the start position, after it the end position,
  /// both at standstill. \rtsafe
  [[nodiscard]] AxisSetpoint evaluate(double elapsed_s) const noexcept;

  /// Whether the ramp has ended. \rtsafe
  [[nodiscard]] bool finished(double elapsed_s) const noexcept { return elapsed_s >= duration_s_; }
  /// Duration of the ramp; zero if start and end are the same. \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return duration_s_; }

 private:
  StartRamp(double from, double to, double duration_s) noexcept : from_(from), to_(to), duration_s_(duration_s) {}

  double from_;
  double to_;
  double duration_s_;
};

}  // namespace driveline::trajectory
