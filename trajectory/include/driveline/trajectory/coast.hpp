#pragma once

#include <cstdint>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Estimates the position of a drive while setpoints do not reach it: the drive continues its motion for some periods
/// and then decelerates. A plain value without heap memory.
class Coast {
 public:
  Coast() = default;
  /// `straight`: number of periods with the last velocity or acceleration; afterwards the drive decelerates by
  /// `deceleration`, in rad/s^2 or m/s^2 (0: never).
  Coast(std::uint32_t straight, double deceleration) noexcept : straight_(straight), deceleration_(deceleration) {}

  /// Reports that a setpoint has reached the drive; `velocity` is the velocity of the step to it. `acceleration`,
  /// rad/s^2 or m/s^2: acceleration with which a drive that holds its torque continues; 0: it holds its velocity.
  /// \rtsafe
  void give(double position, double velocity, double acceleration = 0.0) noexcept;
  /// Reports that a period has passed without a setpoint for the drive. \rtsafe
  void step(double period_s) noexcept;
  /// Reports that `periods` periods have passed without a setpoint; the same as that many calls of step(), but their
  /// number costs no time. \rtsafe
  void skip(std::int64_t periods, double period_s) noexcept;

  /// Current estimated position, rad or m. \rtsafe
  [[nodiscard]] double position() const noexcept { return position_; }
  /// Current estimated velocity, rad/s or m/s.
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// Returns the setpoint that continues the estimated motion if it is sent one period from now. \rtsafe
  [[nodiscard]] AxisSetpoint next(double period_s) const noexcept;

 private:
  void go_straight(double periods, double period_s) noexcept;
  void slow_down(double periods, double period_s) noexcept;

  std::uint32_t straight_ = 0;
  double deceleration_ = 0.0;
  std::uint32_t missed_ = 0;
  double position_ = 0.0;
  double velocity_ = 0.0;
  double acceleration_ = 0.0;
};

}  // namespace driveline::trajectory
