#pragma once

#include <cstdint>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Estimates where a drive is while setpoints do not reach it: it goes on as it moved for some periods and then slows
/// down. A plain value without memory of its own.
class Coast {
 public:
  Coast() = default;
  /// `straight`: number of periods with the last velocity or acceleration; then the drive slows down by `deceleration`,
  /// in rad/s^2 or m/s^2 (0: never).
  Coast(std::uint32_t straight, double deceleration) noexcept : straight_(straight), deceleration_(deceleration) {}

  /// A setpoint has reached the drive; `velocity` is that of the step to it. `acceleration`, rad/s^2 or m/s^2: with
  /// which a drive that holds its torque goes on; 0: it holds its velocity. \rtsafe
  void give(double position, double velocity, double acceleration = 0.0) noexcept;
  /// A period has passed without a setpoint for the drive. \rtsafe
  void step(double period_s) noexcept;

  /// The estimated position now, in rad or m. \rtsafe
  [[nodiscard]] double position() const noexcept { return position_; }
  /// The estimated velocity now, in rad/s or m/s.
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// The setpoint that, sent one period from now, continues the estimated motion. \rtsafe
  [[nodiscard]] AxisSetpoint next(double period_s) const noexcept;

 private:
  std::uint32_t straight_ = 0;
  double deceleration_ = 0.0;
  std::uint32_t missed_ = 0;
  double position_ = 0.0;
  double velocity_ = 0.0;
  double acceleration_ = 0.0;
};

}  // namespace driveline::trajectory
