#pragma once

#include <limits>
#include <optional>

#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/rejoin.hpp"
#include "driveline/trajectory/setpoint.hpp"
#include "driveline/trajectory/stop_profile.hpp"

namespace driveline::trajectory {

/// Limits of an axis that follows unchecked setpoints.
struct FollowLimits {
  AxisLimits motion;                                          ///< velocity and acceleration limits, positive and finite
  double max_jerk = std::numeric_limits<double>::infinity();  ///< jerk limit of a stop, rad/s^3 or m/s^3, positive
};

/// The demand of an axis that follows arbitrary setpoints and never exceeds its limits of velocity and acceleration,
/// which apply to the change from one position to the next. It stays on the setpoints while these keep the limits;
/// otherwise it leaves them and returns (Rejoin), and it stops with bounded jerk (StopProfile). If the jerk limit would
/// violate another limit, the jerk limit yields. A plain value without heap memory.
class LimitedAxis {
 public:
  LimitedAxis() = default;
  /// Starts at rest at 0. `period_s`: time between steps.
  LimitedAxis(const FollowLimits& limits, double period_s) noexcept
      : limits_(limits),
        period_s_(period_s),
        rate_hz_(1.0 / period_s),
        most_change_(limits.motion.max_acceleration * period_s) {}

  /// Restarts at rest at `position`. \rtsafe
  void rest_at(double position) noexcept;
  /// Returns the setpoint one step later, towards `target`, which must be finite. \rtsafe
  AxisSetpoint follow(const AxisSetpoint& target) noexcept;
  /// Returns the setpoint one step later while the axis stops. \rtsafe
  AxisSetpoint stop() noexcept;

  /// Whether the last step was to the target itself. \rtsafe
  [[nodiscard]] bool on_target() const noexcept { return !pursuit_ && !stop_; }
  /// Whether the stop is complete. \rtsafe
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
  double most_change_ = 0.0;  // largest velocity change per step
  AxisSetpoint last_{};
  double step_velocity_ = 0.0;  // velocity of the last position step
  std::optional<Rejoin> pursuit_;
  std::optional<StopProfile> stop_;
  double stopping_s_ = 0.0;  // time since the stop was planned
  bool at_rest_ = true;
};

}  // namespace driveline::trajectory
