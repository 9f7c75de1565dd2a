#pragma once

#include <cstdint>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Where a drive is taken to be whose setpoints do not reach it: it goes on straight at its last speed for some periods
/// and then slows down. A plain value without memory of its own.
class Coast {
 public:
  Coast() = default;
  /// `straight`: periods at the last speed; then it slows down by `deceleration` (per square second; 0: never).
  Coast(std::uint32_t straight, double deceleration) noexcept : straight_(straight), deceleration_(deceleration) {}

  /// A setpoint has reached the drive; `velocity` is that of the step to it. \rtsafe
  void give(double position, double velocity) noexcept;
  /// A period has passed in which none did. \rtsafe
  void step(double period_s) noexcept;

  /// Of now. \rtsafe
  [[nodiscard]] double position() const noexcept { return position_; }
  /// See position().
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// The setpoint that changes nothing for the drive when it comes a period from now. \rtsafe
  [[nodiscard]] AxisSetpoint next(double period_s) const noexcept;

 private:
  std::uint32_t straight_ = 0;
  double deceleration_ = 0.0;
  std::uint32_t missed_ = 0;
  double position_ = 0.0;
  double velocity_ = 0.0;
};

}  // namespace driveline::trajectory
