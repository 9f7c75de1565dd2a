#pragma once

#include <cstdint>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/trajectory/coast.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// Which setpoints have reached the drive of an axis, and where it is without them. A plain value; everything but the
/// constructor is \rtsafe.
class SetpointSupply {
 public:
  SetpointSupply() = default;
  /// `period_s`: of the cycle.
  SetpointSupply(const AxisConfig& axis, double period_s);

  /// Whether the drive has taken the outputs of this cycle, as far as its working counter tells.
  void set_reached(bool reached) noexcept { reached_ = reached; }
  /// set_reached() of this cycle.
  [[nodiscard]] bool reached() const noexcept { return reached_; }

  /// Once per cycle, behind set_reached(): the setpoint that was sent.
  void note(const trajectory::AxisSetpoint& sent) noexcept;
  /// The axis is at rest there.
  void rest_at(double position) noexcept;
  /// `missed` periods have passed in which nothing was sent.
  void skip(std::int64_t missed) noexcept;

  /// The next setpoint of a drive that may not have got the last one: continues from the position that it has reached
  /// without it. If only the answer was lost, the drive has followed the setpoint that was sent: the step from that one
  /// is within the limits, too.
  [[nodiscard]] trajectory::AxisSetpoint bridge() const noexcept;

  /// The last setpoint that left, in rad or m.
  [[nodiscard]] double sent() const noexcept { return sent_; }
  /// The velocity of the step to it.
  [[nodiscard]] double sent_velocity() const noexcept { return sent_velocity_; }

 private:
  trajectory::Coast coast_{};
  double max_velocity_ = 0.0;
  double max_acceleration_ = 0.0;
  double period_s_ = 1.0;
  double sent_ = 0.0;
  double sent_velocity_ = 0.0;
  bool reached_ = true;
};

}  // namespace driveline::ecat_master
