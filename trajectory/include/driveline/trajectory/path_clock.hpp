#pragma once

#include <span>

#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::trajectory {

/// State of the motion along a path at one moment.
struct PathMoment {
  double path_s = 0.0;  ///< time along the path
  double rate = 1.0;    ///< seconds along the path per second
  double slope = 0.0;   ///< change of the rate per second

  /// `setpoint` of the path at path_s, with velocity and acceleration scaled to this rate. \rtsafe
  [[nodiscard]] AxisSetpoint scaled(const AxisSetpoint& setpoint) const noexcept {
    return {setpoint.position, setpoint.velocity * rate,
            setpoint.acceleration * rate * rate + setpoint.velocity * slope};
  }
};

/// The time along a path, which can be stopped and restarted while all axes stay on the path. At full speed it advances
/// exactly with real time. A plain value without heap memory.
class PathClock {
 public:
  PathClock() = default;
  /// `ramp_s`: time from full speed to rest and back, positive. `catch_up`: highest rate, at least 1, at which the path
  /// makes up for lost time; 1: it stays late.
  explicit PathClock(double ramp_s, double catch_up = 1.0) noexcept : ramp_s_(ramp_s), catch_up_(catch_up) {}

  /// Restarts at `path_s` at the time `now_s`, at full speed or at rest. \rtsafe
  void start(double now_s, double path_s, bool running) noexcept;
  /// Starts or stops the path time; from now on its rate ramps up or down. \rtsafe
  void run(bool running) noexcept { running_ = running; }
  /// Reports `lost_s` seconds in which the axes did not move along the path. \rtsafe
  void fall_behind(double lost_s) noexcept { behind_s_ += lost_s; }
  /// Sets behind_s() to zero. \rtsafe
  void be_on_time() noexcept { behind_s_ = 0.0; }
  /// Lost time that has not been caught up, in s. \rtsafe
  [[nodiscard]] double behind_s() const noexcept { return behind_s_; }
  /// Advances to `now_s`, which must not decrease; returns the time along the path. \rtsafe
  double advance(double now_s) noexcept;

  /// Time along the path. \rtsafe
  [[nodiscard]] double path_s() const noexcept { return path_s_; }
  /// Whether the path time stands still. \rtsafe
  [[nodiscard]] bool at_rest() const noexcept { return rate_ <= 0.0; }
  /// `setpoint` with velocity and acceleration scaled to the current rate. \rtsafe
  [[nodiscard]] AxisSetpoint scaled(const AxisSetpoint& setpoint) const noexcept { return moment().scaled(setpoint); }
  /// The current state of the motion. \rtsafe
  [[nodiscard]] PathMoment moment() const noexcept { return {path_s_, rate_, slope_}; }

 private:
  [[nodiscard]] double wanted_rate(double step) const noexcept;
  [[nodiscard]] double approached(double goal, double step) const noexcept;

  double ramp_s_ = 1.0;
  double catch_up_ = 1.0;
  double behind_s_ = 0.0;
  bool running_ = true;
  double rate_ = 1.0;   ///< seconds along the path per second
  double slope_ = 0.0;  ///< change of the rate per second in the last step
  double now_s_ = 0.0;
  double path_s_ = 0.0;
  double since_s_ = 0.0;  ///< time at which full speed was reached
  double since_path_s_ = 0.0;
};

/// The highest rate, from 1 to 1.25, at which every axis stays within `limits`, also on the ramp to that rate and back
/// (a quarter as steep as `ramp_s`). It is 1, no catching up, for a path of straight lines or held points. For
/// start-up.
[[nodiscard]] double path_catch_up_rate(Interpolator path, std::span<const AxisLimits> limits, double ramp_s);

/// The shortest time, in s, in which a path can be stopped from full speed with every axis within `limits` (one per
/// axis). Braking uses the part of the limit that the path's own acceleration leaves, at least a quarter. Evaluates the
/// path at some thousand points; for start-up.
[[nodiscard]] double path_ramp_s(Interpolator path, std::span<const AxisLimits> limits);

}  // namespace driveline::trajectory
