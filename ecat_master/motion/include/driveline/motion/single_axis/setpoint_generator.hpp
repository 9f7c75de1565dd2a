#pragma once

#include <optional>

#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Generates the setpoints of an axis over time: to a position, at a velocity, or to rest. A new aim starts from the
/// last setpoint, so that nothing jumps. Everything is \rtsafe; a plain value.
class SetpointGenerator {
 public:
  /// The last setpoint: position, velocity and acceleration.
  [[nodiscard]] const trajectory::AxisSetpoint& state() const noexcept { return state_; }
  /// Continues from `state`, at its velocity, until a new aim is given.
  void start_from(const trajectory::AxisSetpoint& state) noexcept;

  /// Moves to a position in the shortest time, passing it at the velocity of `to`. Returns false if that cannot be
  /// planned; then the aim is unchanged.
  [[nodiscard]] bool to_position(const trajectory::AxisSetpoint& to, const trajectory::ProfileLimits& limits) noexcept;
  /// Moves to a velocity and holds it. Returns false as to_position().
  [[nodiscard]] bool to_velocity(double velocity, const trajectory::ProfileLimits& limits) noexcept;

  /// Sets the profile that follows at the end of the present one; another aim discards it.
  void go_on_with(const trajectory::Profile& next) noexcept { next_ = next; }
  /// Whether a following profile is set and has not started.
  [[nodiscard]] bool goes_on() const noexcept { return next_.has_value(); }

  /// Returns the setpoint one period later. \rtsafe
  const trajectory::AxisSetpoint& advance(double period_s) noexcept;
  /// Whether the aim is reached, including that of a following profile. \rtsafe
  [[nodiscard]] bool finished() const noexcept { return !next_ && profile_.finished(elapsed_s_); }

 private:
  void take(const trajectory::Profile& profile) noexcept;

  trajectory::AxisSetpoint state_{};
  trajectory::Profile profile_{};
  std::optional<trajectory::Profile> next_{};
  double elapsed_s_ = 0.0;
};

}  // namespace driveline::motion
