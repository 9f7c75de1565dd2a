#pragma once

#include <optional>

#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// The setpoints of one axis in time: to a position, at a velocity, to rest. A new aim begins with the state of the
/// last setpoint, so nothing leaps. Everything is \rtsafe; a plain value.
class SetpointGenerator {
 public:
  /// The last setpoint: position, velocity and acceleration.
  [[nodiscard]] const trajectory::AxisSetpoint& state() const noexcept { return state_; }
  /// Goes on from there, at its velocity, until there is a new aim.
  void start_from(const trajectory::AxisSetpoint& state) noexcept;

  /// To a position, which is passed at the velocity of `to`, in the shortest time. False: it cannot be planned; the aim
  /// stays as it was.
  [[nodiscard]] bool to_position(const trajectory::AxisSetpoint& to, const trajectory::ProfileLimits& limits) noexcept;
  /// To a velocity, and on at it. False as above.
  [[nodiscard]] bool to_velocity(double velocity, const trajectory::ProfileLimits& limits) noexcept;

  /// What follows the way to the aim that was given last, beginning where that ends; another aim takes it away.
  void go_on_with(const trajectory::Profile& next) noexcept { next_ = next; }
  /// Something follows, and has not begun.
  [[nodiscard]] bool goes_on() const noexcept { return next_.has_value(); }

  /// The setpoint one step later. \rtsafe
  const trajectory::AxisSetpoint& advance(double period_s) noexcept;
  /// The aim is reached, that of what follows, if there is something. \rtsafe
  [[nodiscard]] bool finished() const noexcept { return !next_ && profile_.finished(elapsed_s_); }

 private:
  void take(const trajectory::Profile& profile) noexcept;

  trajectory::AxisSetpoint state_{};
  trajectory::Profile profile_{};
  std::optional<trajectory::Profile> next_{};
  double elapsed_s_ = 0.0;
};

}  // namespace driveline::ecat_master
