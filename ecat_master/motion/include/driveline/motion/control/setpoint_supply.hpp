#pragma once

#include <cstdint>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/trajectory/coast.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Tracks which setpoints have reached the drive of an axis, and where the axis is without them. A plain value;
/// everything except the constructor is \rtsafe.
class SetpointSupply {
 public:
  SetpointSupply() = default;
  /// `period_s`: cycle time. `divider`: the drive is exchanged in every n-th cycle.
  SetpointSupply(const AxisConfig& axis, double period_s, std::uint32_t divider = 1);

  /// Sets whether the drive took the outputs of its last exchange, according to its working counter. `due`: that
  /// exchange was in this cycle.
  void set_reached(bool reached, bool due = true) noexcept {
    reached_ = reached;
    due_ = due;
  }
  /// Value of set_reached() in this cycle. A drive that is not exchanged in this cycle still lacks the setpoint of a
  /// failed exchange.
  [[nodiscard]] bool reached() const noexcept { return reached_; }

  /// Consecutive setpoints that the drive has certainly not received, those of skip() included; 0 where that is not
  /// known. A drive that lacks more than it bridges brakes on its own.
  [[nodiscard]] std::int64_t lacking() const noexcept { return certain_ ? lacking_ : 0; }

  /// To be called once per cycle, after set_reached(): the setpoint that was sent, and the mode of the drive.
  void note(const trajectory::AxisSetpoint& sent, cia402::Mode mode) noexcept;
  /// Continues from there, whatever was sent before.
  void start_from(const trajectory::AxisSetpoint& from) noexcept;
  /// Accounts for `missed` periods in which nothing was sent to a drive in this mode. With AxisConfig::loss_is_certain
  /// the setpoint of the period before is lost, too.
  void skip(std::int64_t missed, cia402::Mode mode) noexcept;

  /// The next setpoint for a drive that may not have received the last one: continues from the position that the drive
  /// has reached without it. If only the answer was lost, the drive has followed the last setpoint; the step from that
  /// one is within the limits, too. If the master closes the loops, it continues from the last sent setpoint, with the
  /// velocity that the drive holds, or the acceleration of the torque that it holds: whether the drive received the
  /// last setpoint or the one before, it is one step away, and the loops see the actual position. A drive that has
  /// certainly not received it (AxisConfig::loss_is_certain) is met exactly where it goes. For a drive that is
  /// exchanged in every n-th cycle, a step is that between two exchanges, because it sees no setpoint in between.
  ///
  /// `held_up`: consecutive cycles, this one included, in which the drive got its setpoints but the motion waits for
  /// other axes. After as many as other drives bridge, this one is braked as they brake.
  [[nodiscard]] trajectory::AxisSetpoint bridge(std::uint32_t held_up = 0) const noexcept;

  /// The last setpoint sent, or where the drive is that has certainly not received it, rad or m.
  [[nodiscard]] double sent() const noexcept { return sent_; }
  /// Velocity at which the drive continues from it: that of the step to it, or the velocity held in CSV and CST.
  [[nodiscard]] double sent_velocity() const noexcept { return sent_velocity_; }

  /// Whether a drive without new targets holds its torque, so that the loops of the master react late.
  [[nodiscard]] bool by_torque() const noexcept { return mode_ == cia402::Mode::kCyclicTorque; }

 private:
  void set_mode(cia402::Mode mode) noexcept;
  void note_exchange() noexcept;
  void note_lost() noexcept;
  void expect_from_coast() noexcept;
  [[nodiscard]] trajectory::AxisSetpoint bridge_to_exchange() const noexcept;
  [[nodiscard]] trajectory::AxisSetpoint brake() const noexcept;
  /// Whether the drive follows positions and sees only some of them.
  [[nodiscard]] bool by_exchanges() const noexcept;
  [[nodiscard]] double held_acceleration() const noexcept;

  cia402::Mode mode_ = cia402::Mode::kCyclicPosition;
  trajectory::Coast coast_{};
  trajectory::Coast before_{};  ///< without the last setpoint
  double max_velocity_ = 0.0;
  double max_acceleration_ = 0.0;
  double period_s_ = 1.0;
  double sent_ = 0.0;
  double sent_velocity_ = 0.0;
  double sent_acceleration_ = 0.0;
  bool reached_ = true;
  bool due_ = true;
  bool certain_ = false;  ///< AxisConfig::loss_is_certain, of a drive that is exchanged in every cycle
  std::int64_t lacking_ = 0;
  std::uint32_t divider_ = 1;
  std::uint32_t since_ = 0;        ///< cycles since the drive was last due
  double offered_ = 0.0;           ///< position sent in that exchange, rad or m
  double offered_velocity_ = 0.0;  ///< velocity of the step between the last two exchanges, rad/s or m/s
};

}  // namespace driveline::motion
