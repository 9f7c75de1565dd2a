#pragma once

#include <span>

#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::trajectory {

/// The time along a path, which can be brought to rest and set going again while all axes stay on the path. While it
/// runs at full speed it is exactly the time that has passed. A plain value without memory of its own.
class PathClock {
 public:
  PathClock() = default;
  /// `ramp_s`: from full speed to rest and back, positive. `catch_up`: highest rate, at least 1, at which the path
  /// makes up for the time it is late; 1: it stays late.
  explicit PathClock(double ramp_s, double catch_up = 1.0) noexcept : ramp_s_(ramp_s), catch_up_(catch_up) {}

  /// Begins anew at `path_s` when `now_s` is the time, at full speed or at rest. \rtsafe
  void start(double now_s, double path_s, bool running) noexcept;
  /// Whether it is to run (from now on slower and slower, or faster and faster). \rtsafe
  void run(bool running) noexcept { running_ = running; }
  /// Time has passed in which nobody went along the path. \rtsafe
  void fall_behind(double lost_s) noexcept { behind_s_ += lost_s; }
  /// Forgets what has been lost. \rtsafe
  void be_on_time() noexcept { behind_s_ = 0.0; }
  /// What fall_behind() was told, without what has been caught up. \rtsafe
  [[nodiscard]] double behind_s() const noexcept { return behind_s_; }
  /// Time goes on to `now_s`, not before the time of the call before; the time along the path. \rtsafe
  double advance(double now_s) noexcept;

  /// Time along the path. \rtsafe
  [[nodiscard]] double path_s() const noexcept { return path_s_; }
  /// At rest. \rtsafe
  [[nodiscard]] bool at_rest() const noexcept { return rate_ <= 0.0; }
  /// A setpoint of the path as the axis passes it at the present speed. \rtsafe
  [[nodiscard]] AxisSetpoint scaled(const AxisSetpoint& setpoint) const noexcept;

 private:
  [[nodiscard]] double wanted_rate(double step) const noexcept;
  [[nodiscard]] double approached(double goal, double step) const noexcept;

  double ramp_s_ = 1.0;
  double catch_up_ = 1.0;
  double behind_s_ = 0.0;
  bool running_ = true;
  double rate_ = 1.0;   ///< seconds along the path per second
  double slope_ = 0.0;  ///< of the rate, per second, in the last step
  double now_s_ = 0.0;
  double path_s_ = 0.0;
  double since_s_ = 0.0;  ///< when full speed was reached, and where
  double since_path_s_ = 0.0;
};

/// The highest rate, up to 1.25, at which a path can be run with every axis keeping within `limits`, also on the way to
/// that rate and back (a quarter as steep as `ramp_s`); at least 1, which leaves the path as it is; so it is for a path
/// of straight lines. For start-up.
[[nodiscard]] double path_catch_up_rate(Interpolator path, std::span<const AxisLimits> limits, double ramp_s);

/// The shortest time in which a path can be brought from full speed to rest with every axis keeping within `limits`
/// (one per axis): what the acceleration of the path leaves of them, at least a quarter. Evaluates the path at some
/// thousand points; for start-up.
[[nodiscard]] double path_ramp_s(Interpolator path, std::span<const AxisLimits> limits);

}  // namespace driveline::trajectory
