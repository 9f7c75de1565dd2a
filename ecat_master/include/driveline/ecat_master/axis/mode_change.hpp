#pragma once

#include <cstdint>

#include "driveline/ecat_master/cia402/cia402.hpp"
#include "driveline/trajectory/deviation.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// Takes an axis from one mode into another while it moves, between cyclic modes without a step.
///
/// The drive changes at a cycle that is not known before 6061h shows it. Until then every target is valid in whatever
/// mode the drive is in: the velocity by the position loop of the master, the torque by its velocity loop and what the
/// drive's own torque is beyond that, the position as far ahead as the axis gets until the drive has arrived there.
/// Then the axis returns from what it did to its setpoints, within its limits.
///
/// A plain value without memory of its own; all functions are \rtsafe.
class ModeChange {
 public:
  /// Constants of an axis.
  struct Settings {
    trajectory::AxisLimits limits{};  ///< for the return to the setpoints
    double period_s = 125e-6;         ///< from one setpoint to the next
    double lead_cycles = 3.0;         ///< setpoint_delay_cycles() of position setpoints
    double least_torque = 0.0;        ///< Nm or N that make no difference
    double inertia = 0.0;             ///< kg m^2 or kg; 0: not known
  };
  /// What was measured in this cycle, in units of the axis.
  struct Measured {
    double position = 0.0;      ///< rad or m
    double velocity = 0.0;      ///< rad/s or m/s
    double torque = 0.0;        ///< Nm or N
    bool fresh = false;         ///< it is of this cycle, and can be believed
    bool torque_known = false;  ///< the process data have the torque
    cia402::Mode shown{};       ///< 6061h
    double led_velocity = 0.0;  ///< that the axis has by its position setpoints now, rad/s or m/s
  };

  ModeChange() = default;
  /// Idle.
  explicit ModeChange(const Settings& settings) noexcept : settings_(settings) {}

  /// The last targets of an axis, rad or m, rad/s or m/s, rad/s^2 or m/s^2, Nm or N.
  struct Targets {
    double position = 0.0;
    double velocity = 0.0;
    double torque = 0.0;
    double acceleration = 0.0;  ///< of the setpoint
    double feed_velocity = 0.0;
  };
  /// The drive is to get into another mode.
  void begin(const Measured& measured, const Targets& last) noexcept;
  /// The loops of the master begin at the setpoints, at this velocity, and add this torque, Nm or N, which fades.
  void carry(double torque, double velocity) noexcept {
    torque_bias_ = torque;
    on_setpoints_ = true;
    leading_ = false;
    feed_velocity_ = velocity;
    phase_ = Phase::kReturning;
  }
  /// The axis does not move by its setpoints any more.
  void cancel() noexcept { phase_ = Phase::kNone; }
  /// Whether targets come from here.
  [[nodiscard]] bool active() const noexcept { return phase_ != Phase::kNone; }
  /// Whether the drive may be in any mode.
  [[nodiscard]] bool pending() const noexcept { return phase_ == Phase::kPending; }
  /// The axis is on its way to its setpoints, which takes some of its acceleration.
  [[nodiscard]] bool returning() const noexcept { return active() && !on_setpoints_; }
  /// What the drive is to be told (6060h) when it is to get into `wanted`: the mode it is in until its motion is known.
  [[nodiscard]] cia402::Mode told(cia402::Mode wanted) const noexcept {
    return pending() && preparing_ > 0 ? from_ : wanted;
  }
  /// By which the drive goes on while nothing reaches it: in the mode that it was told last and has heard of, unless it
  /// has not changed for so long that it is slow.
  [[nodiscard]] cia402::Mode in_force(cia402::Mode wanted) const noexcept;
  /// The drive has been told, and may change at any moment: it must not be told to go back, unless it takes so long
  /// that it is not going to change.
  [[nodiscard]] bool committed() const noexcept;

  /// So many periods have gone by without a cycle.
  void skip(std::int64_t periods, cia402::Mode wanted) noexcept;
  /// To be called first in a cycle. While the mode shown is not `wanted`, or has not been for long, it stays pending().
  void look(const Measured& measured, cia402::Mode wanted) noexcept;
  /// What the axis is to do in this cycle so that it gets to `setpoint`: on its way in terms of the actual position, or
  /// of the target position once it is in CSP.
  [[nodiscard]] trajectory::AxisSetpoint reference(const Measured& measured,
                                                   const trajectory::AxisSetpoint& setpoint) noexcept;
  /// What the loops of the master want for reference(), which has the acceleration.
  struct Wanted {
    double velocity = 0.0;      ///< rad/s or m/s
    double torque = 0.0;        ///< Nm or N
    double acceleration = 0.0;  ///< rad/s^2 or m/s^2
  };
  /// While pending().
  void follow(const Measured& measured, const Wanted& wanted) noexcept;

  /// Position of the last reference(); rad or m.
  [[nodiscard]] double reference_position() const noexcept { return reference_position_; }
  /// After follow(): targets of all modes. rad or m
  [[nodiscard]] double position() const noexcept { return position_; }
  /// rad/s or m/s
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// Share of the feed-forward in the velocity, rad/s or m/s: in CSP of the setpoint, before and behind of what the
  /// axis does, and never with a step.
  [[nodiscard]] double feed_velocity() const noexcept { return feed_velocity_; }
  /// What is to be added to the torque of the master's loop, Nm or N.
  [[nodiscard]] double torque_bias() const noexcept { return torque_bias_; }

 private:
  enum class Phase : std::uint8_t { kNone, kPending, kReturning };

  void settle(const Measured& measured, cia402::Mode mode) noexcept;
  void return_from(double position, double velocity) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint lead(const Measured& measured,
                                              const trajectory::AxisSetpoint& setpoint) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint approach(const trajectory::AxisSetpoint& setpoint) noexcept;
  void fade() noexcept;
  void feed(const Measured& measured, const trajectory::AxisSetpoint& reference) noexcept;
  void observe(const Measured& measured) noexcept;
  void expect(double torque) noexcept;
  void hold_torque() noexcept;
  [[nodiscard]] double gradually(double velocity) const noexcept;
  void place(bool by_position, double velocity) noexcept;
  /// The drive has not left CSP yet.
  [[nodiscard]] bool led(const Measured& measured) const noexcept {
    return pending() && leading_ && measured.shown == cia402::Mode::kCyclicPosition;
  }

  Settings settings_{};
  trajectory::Deviation return_{};  ///< to the setpoints
  trajectory::AxisSetpoint led_{};  ///< what the axis did by its position setpoints
  double reference_position_ = 0.0;
  double position_ = 0.0;  ///< target position that goes on with the motion
  double position_velocity_ = 0.0;
  double position_acceleration_ = 0.0;  ///< while the drive is led
  double velocity_ = 0.0;               ///< target velocity that does
  double lowest_held_ = 0.0;            ///< of those that the drive may have got last
  double highest_held_ = 0.0;
  double velocity_bias_ = 0.0;
  double lag_ = 0.0;                     ///< velocity by which the axis was behind its velocity target
  trajectory::AxisSetpoint observed_{};  ///< what the axis does
  double on_its_way_ = 0.0;              ///< acceleration that the torques told last are going to add
  double told_torque_[4] = {};           ///< in the cycles before
  double feed_velocity_ = 0.0;
  double before_[2] = {};        ///< velocities that were wanted in the cycles before
  cia402::Mode from_{};          ///< in which the change began
  std::uint32_t preparing_ = 0;  ///< cycles until the drive is told
  double told_s_ = 0.0;          ///< time since then
  double torque_bias_ = 0.0;
  std::uint32_t shown_ = 0;  ///< exchanges in a row in which the wanted mode was shown
  Phase phase_ = Phase::kNone;
  bool first_ = false;         ///< cycle of the change
  bool heard_ = false;         ///< the drive has got a frame in which it was told
  bool fed_ = false;           ///< feed_velocity_ is that of the reference
  bool leading_ = false;       ///< the change began in CSP, which the drive has not left
  bool on_setpoints_ = false;  ///< the reference is the setpoint
};

}  // namespace driveline::ecat_master
