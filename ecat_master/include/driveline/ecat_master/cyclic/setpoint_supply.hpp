#pragma once

#include <cstdint>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/trajectory/coast.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// Tracks which setpoints have reached the drive of an axis, and where the axis is without them. A plain value;
/// everything except the constructor is \rtsafe.
class SetpointSupply {
 public:
  SetpointSupply() = default;
  /// `period_s`: cycle time.
  SetpointSupply(const AxisConfig& axis, double period_s);

  /// Sets whether the drive took the outputs of this cycle, according to its working counter.
  void set_reached(bool reached) noexcept { reached_ = reached; }
  /// Value of set_reached() in this cycle.
  [[nodiscard]] bool reached() const noexcept { return reached_; }

  /// To be called once per cycle, after set_reached(): the setpoint that was sent, and the mode of the drive.
  void note(const trajectory::AxisSetpoint& sent, cia402::Mode mode) noexcept;
  /// Continues from there, whatever was sent before.
  void start_from(const trajectory::AxisSetpoint& from) noexcept;
  /// Accounts for `missed` periods in which nothing was sent to a drive in this mode.
  void skip(std::int64_t missed, cia402::Mode mode) noexcept;

  /// The next setpoint for a drive that may not have received the last one: continues from the position that the drive
  /// has reached without it. If only the answer was lost, the drive has followed the last setpoint; the step from that
  /// one is within the limits, too. If the master closes the loops, it continues from the last sent setpoint, with the
  /// velocity that the drive holds, or the acceleration of the torque that it holds: whether the drive received the
  /// last setpoint or the one before, it is one step away, and the loops see the actual position.
  [[nodiscard]] trajectory::AxisSetpoint bridge() const noexcept;

  /// The last setpoint sent, rad or m.
  [[nodiscard]] double sent() const noexcept { return sent_; }
  /// Velocity at which the drive continues from it: that of the step to it, or the velocity held in CSV and CST.
  [[nodiscard]] double sent_velocity() const noexcept { return sent_velocity_; }

  /// Whether a drive without new targets holds its torque, so that the loops of the master react late.
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
