#pragma once

#include <limits>
#include <optional>

#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/rejoin.hpp"
#include "driveline/trajectory/setpoint.hpp"
#include "driveline/trajectory/stop_profile.hpp"

namespace driveline::trajectory {

/// Limits of an axis that follows setpoints that nobody has checked.
struct FollowLimits {
  AxisLimits motion;                                          ///< positive and finite
  double max_jerk = std::numeric_limits<double>::infinity();  ///< of a stop, rad/s^3 or m/s^3, positive
};

/// The demand of one axis that follows any setpoints without ever breaking the limits of velocity and acceleration,
/// which are held by the change from one position to the next: on the setpoints where they keep the limits themselves,
/// otherwise beside them and back (Rejoin), and to rest with bounded jerk (StopProfile). Where the jerk would break
/// another limit, it gives way. A plain value without memory of its own.
class LimitedAxis {
 public:
  LimitedAxis() = default;
  /// At rest at 0. `period_s`: from step to step.
  LimitedAxis(const FollowLimits& limits, double period_s) noexcept
      : limits_(limits),
        period_s_(period_s),
        rate_hz_(1.0 / period_s),
        most_change_(limits.motion.max_acceleration * period_s) {}

  /// At rest at a position. \rtsafe
  void rest_at(double position) noexcept;
  /// The setpoint one step later, towards `target`, which must be finite. \rtsafe
  AxisSetpoint follow(const AxisSetpoint& target) noexcept;
  /// The setpoint one step later, on the way to rest. \rtsafe
  AxisSetpoint stop() noexcept;

  /// The last step was to the target itself. \rtsafe
  [[nodiscard]] bool on_target() const noexcept { return !pursuit_ && !stop_; }
  /// The way to rest has ended. \rtsafe
  [[nodiscard]] bool at_rest() const noexcept { return at_rest_; }

 private:
  [[nodiscard]] double limited_step(double step_velocity) const noexcept;
  [[nodiscard]] double step_velocity_to(double position) const noexcept {
    return (position - last_.position) * rate_hz_;
  }
  [[nodiscard]] bool is_allowed(double position) const noexcept;
  AxisSetpoint take(const AxisSetpoint& next) noexcept;
  AxisSetpoint take_nearest(double position) noexcept;

  FollowLimits limits_{};
  double period_s_ = 1.0;
  double rate_hz_ = 1.0;
  double most_change_ = 0.0;  // of the velocity from step to step
  AxisSetpoint last_{};
  double step_velocity_ = 0.0;  // from the last position but one to the last
  std::optional<Rejoin> pursuit_;
  std::optional<StopProfile> stop_;
  double stopping_s_ = 0.0;  // since the stop was planned
  bool at_rest_ = true;
};

}  // namespace driveline::trajectory
