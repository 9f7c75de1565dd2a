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

  /// Once per cycle, behind set_reached(): the setpoint that was sent, and the mode that the drive is in.
  void note(const trajectory::AxisSetpoint& sent, cia402::Mode mode) noexcept;
  /// The axis goes on from there, whatever has been sent before.
  void start_from(const trajectory::AxisSetpoint& from) noexcept;
  /// `missed` periods have passed in which nothing was sent, and the drive was in this mode.
  void skip(std::int64_t missed, cia402::Mode mode) noexcept;

  /// The next setpoint of a drive that may not have got the last one: continues from the position that it has reached
  /// without it. If only the answer was lost, the drive has followed the setpoint that was sent: the step from that one
  /// is within the limits, too. Where the master closes the loops it goes on from the last one that was sent, with the
  /// velocity that the drive holds, or the acceleration by the torque that it holds: whether it has got the last one or
  /// the one before, it is one step away, and the loops see where it is.
  [[nodiscard]] trajectory::AxisSetpoint bridge() const noexcept;

  /// The last setpoint that left, in rad or m.
  [[nodiscard]] double sent() const noexcept { return sent_; }
  /// The velocity with which the drive goes on from it: that of the step to it, or which it holds in CSV and CST.
  [[nodiscard]] double sent_velocity() const noexcept { return sent_velocity_; }

  /// A drive that gets nothing new holds its torque: the loops of the master answer late.
  [[nodiscard]] bool by_torque() const noexcept { return mode_ == cia402::Mode::kCyclicTorque; }

 private:
  void set_mode(cia402::Mode mode) noexcept;
  [[nodiscard]] double held_acceleration() const noexcept;

  cia402::Mode mode_ = cia402::Mode::kCyclicPosition;
  trajectory::Coast coast_{};
  double max_velocity_ = 0.0;
  double max_acceleration_ = 0.0;
  double period_s_ = 1.0;
  double sent_ = 0.0;
  double sent_velocity_ = 0.0;
  double sent_acceleration_ = 0.0;
  bool reached_ = true;
};

}  // namespace driveline::ecat_master
