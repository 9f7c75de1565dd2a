#pragma once

#include <array>
#include <limits>
#include <optional>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Limits of a stop.
struct StopLimits {
  double max_deceleration = 0.0;                              ///< rad/s^2 or m/s^2, positive and finite
  double max_jerk = std::numeric_limits<double>::infinity();  ///< rad/s^3 or m/s^3, positive
};

/// Brings one axis from any state of motion to standstill in the shortest time: the defined reaction to the end or loss
/// of setpoints. With unlimited jerk the velocity falls linearly and the acceleration jumps; with limited jerk the
/// acceleration starts at its present value and follows a trapezoid.
/// With limited jerk an axis that is about to pass through zero velocity (v0 < a0^2 / (2 jerk), acceleration opposed to
/// velocity) overshoots and returns to zero velocity from the other side. An initial acceleration beyond
/// max_deceleration is reduced to it at max_jerk.
/// A plain value without heap memory.
class StopProfile {
 public:
  /// Plans a stop. nullopt if the state is not finite, a limit is invalid, or duration or distance would overflow.
  /// \rtsafe
  [[nodiscard]] static std::optional<StopProfile> plan(const AxisSetpoint& state, const StopLimits& limits) noexcept;

  /// Returns the setpoint at a time after the start of the stop; from duration_s() on the final position at standstill.
  /// Times before zero (and NaN) count as zero. \rtsafe
  [[nodiscard]] AxisSetpoint evaluate(double elapsed_s) const noexcept;

  /// Whether the stop is complete. \rtsafe
  [[nodiscard]] bool finished(double elapsed_s) const noexcept { return elapsed_s >= duration_s_; }
  /// Duration of the stop. \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return duration_s_; }
  /// Position at which the axis comes to rest, rad or m. \rtsafe
  [[nodiscard]] double end_position() const noexcept { return end_position_; }

 private:
  // A phase of constant jerk.
  struct Phase {
    double duration_s = 0.0;
    double jerk = 0.0;
    AxisSetpoint start;

    [[nodiscard]] AxisSetpoint at(double t) const noexcept;
  };

  StopProfile() = default;

  std::array<Phase, 3> phases_;  // to the deceleration, at the deceleration, back to zero
  double duration_s_ = 0.0;
  double end_position_ = 0.0;
};

}  // namespace driveline::trajectory
