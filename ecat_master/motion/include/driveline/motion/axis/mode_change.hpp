#pragma once

#include <cstdint>

#include "driveline/motion/axis/observed_motion.hpp"
#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/trajectory/deviation.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Changes the mode of an axis while it moves; between cyclic modes the change is bumpless.
///
/// The drive changes in a cycle that is known only when 6061h shows the new mode. Until then every target must be valid
/// in either mode: the velocity comes from the position loop of the master; the torque from its velocity loop, plus the
/// difference to the drive's own torque; the position is as far ahead as the axis moves until the drive has reached it.
/// Afterwards the axis returns from its actual motion to its setpoints, within its limits.
///
/// A plain value that allocates no memory; all functions are \rtsafe.
class ModeChange {
 public:
  /// Constants of an axis.
  struct Settings {
    trajectory::AxisLimits limits{};  ///< for the return to the setpoints
    double period_s = 125e-6;         ///< time between two setpoints
    double lead_cycles = 3.0;         ///< setpoint_delay_cycles() of position setpoints
    double least_torque = 0.0;        ///< torque that is negligible, Nm or N
    double inertia = 0.0;             ///< kg m^2 or kg; 0: not known
  };
  /// Measured values of this cycle, in units of the axis.
  struct Measured {
    double position = 0.0;      ///< rad or m
    double velocity = 0.0;      ///< rad/s or m/s
    double torque = 0.0;        ///< Nm or N
    bool fresh = false;         ///< the values are from this cycle and plausible
    bool torque_known = false;  ///< the process data contain the torque
    cia402::Mode shown{};       ///< mode shown by the drive (6061h)
    double led_velocity = 0.0;  ///< velocity that results from the position setpoints now in effect, rad/s or m/s
  };

  ModeChange() = default;
  /// Starts idle.
  explicit ModeChange(const Settings& settings) noexcept
      : settings_(settings), observed_(settings.period_s, settings.inertia) {}

  /// The last targets of an axis, rad or m, rad/s or m/s, rad/s^2 or m/s^2, Nm or N.
  struct Targets {
    double position = 0.0;
    double velocity = 0.0;
    double torque = 0.0;
    double acceleration = 0.0;  ///< acceleration of the setpoint
    double feed_velocity = 0.0;
  };
  /// Starts a mode change at the present motion.
  void begin(const Measured& measured, const Targets& last) noexcept;
  /// Starts the loops of the master at the setpoints, with this velocity, rad/s or m/s, and an additional torque, Nm or
  /// N, which fades.
  void carry(double torque, double velocity) noexcept {
    torque_bias_ = torque;
    on_setpoints_ = true;
    leading_ = false;
    feed_velocity_ = velocity;
    phase_ = Phase::kReturning;
  }
  /// Cancels the change: the axis no longer moves by its setpoints.
  void cancel() noexcept { phase_ = Phase::kNone; }
  /// Whether the targets come from this object.
  [[nodiscard]] bool active() const noexcept { return phase_ != Phase::kNone; }
  /// Whether the drive may be in either mode.
  [[nodiscard]] bool pending() const noexcept { return phase_ == Phase::kPending; }
  /// Whether the axis is returning to its setpoints, which uses part of its acceleration.
  [[nodiscard]] bool returning() const noexcept { return active() && !on_setpoints_; }
  /// Mode to write to 6060h for a change to `wanted`: the old mode until the motion of the axis is known.
  [[nodiscard]] cia402::Mode commanded_mode(cia402::Mode wanted) const noexcept {
    return pending() && preparing_ > 0 ? from_ : wanted;
  }
  /// Mode in which the drive continues while no frame reaches it: the last commanded mode that it has received, unless
  /// it has not confirmed that mode for so long that it counts as slow.
  [[nodiscard]] cia402::Mode in_force(cia402::Mode wanted) const noexcept;
  /// Whether the drive has been commanded and may change at any moment. It must not be commanded back until it has
  /// changed, or has taken so long that it will not.
  [[nodiscard]] bool committed() const noexcept;

  /// Accounts for `periods` periods without a cycle.
  void skip(std::int64_t periods, cia402::Mode wanted) noexcept;
  /// Must be called first in a cycle. The change stays pending() until the drive has shown `wanted` for several
  /// exchanges.
  void update(const Measured& measured, cia402::Mode wanted) noexcept;
  /// Motion for this cycle that leads the axis to `setpoint`: in terms of the actual position while returning, or of
  /// the target position once the drive is in CSP.
  [[nodiscard]] trajectory::AxisSetpoint reference(const Measured& measured,
                                                   const trajectory::AxisSetpoint& setpoint) noexcept;
  /// Output of the master's loops for reference(), and the acceleration of the reference.
  struct Wanted {
    double velocity = 0.0;      ///< rad/s or m/s
    double torque = 0.0;        ///< Nm or N
    double acceleration = 0.0;  ///< rad/s^2 or m/s^2
  };
  /// Computes the targets of all modes; only while pending().
  void follow(const Measured& measured, const Wanted& wanted) noexcept;

  /// Position of the last reference(); rad or m.
  [[nodiscard]] double reference_position() const noexcept { return reference_position_; }
  /// Position target after follow(), rad or m; valid whichever mode the drive is in.
  [[nodiscard]] double position() const noexcept { return target_.position; }
  /// Velocity target after follow(), rad/s or m/s.
  [[nodiscard]] double velocity() const noexcept { return held_.target; }
  /// Part of the velocity that is feed-forward, rad/s or m/s. It is that of the setpoint in CSP, and that of the actual
  /// motion before and after; it never steps.
  [[nodiscard]] double feed_velocity() const noexcept { return feed_velocity_; }
  /// Torque to add to the master's velocity loop, Nm or N.
  [[nodiscard]] double torque_bias() const noexcept { return torque_bias_; }

 private:
  enum class Phase : std::uint8_t { kNone, kPending, kReturning };
  /// Velocity target that continues the motion, and the range of those that the drive may hold after a gap; rad/s or
  /// m/s.
  struct HeldVelocity {
    double target = 0.0;
    double lowest = 0.0;
    double highest = 0.0;
  };
  /// Actual velocity minus the one wanted two cycles ago: a load or a loop causes the difference; rad/s or m/s.
  struct VelocityLag {
    double bias = 0.0;      ///< difference in CST
    double lag = 0.0;       ///< difference in CSV beyond `bias`
    double before[2] = {};  ///< wanted velocities of the last two cycles, newest first
  };

  void settle(const Measured& measured, cia402::Mode mode) noexcept;
  void return_from(double position, double velocity) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint lead(const Measured& measured,
                                              const trajectory::AxisSetpoint& setpoint) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint approach(const trajectory::AxisSetpoint& setpoint) noexcept;
  void fade() noexcept;
  void feed(const Measured& measured, const trajectory::AxisSetpoint& reference) noexcept;
  [[nodiscard]] double gradually(double velocity) const noexcept;
  void place(bool by_position, double velocity) noexcept;
  /// Whether the drive has not left the mode of position setpoints yet.
  [[nodiscard]] bool led(const Measured& measured) const noexcept {
    return pending() && leading_ && cia402::by_position(measured.shown);
  }

  Settings settings_{};
  ObservedMotion observed_{};
  trajectory::Deviation return_{};     ///< return to the setpoints
  trajectory::AxisSetpoint led_{};     ///< motion that results from the position setpoints
  trajectory::AxisSetpoint target_{};  ///< position target that continues the motion; acceleration: while it leads
  HeldVelocity held_{};
  VelocityLag lag_{};
  double reference_position_ = 0.0;
  double feed_velocity_ = 0.0;
  double torque_bias_ = 0.0;
  double elapsed_s_ = 0.0;       ///< time since the command, s; before it: since the motion settled
  std::uint32_t preparing_ = 0;  ///< cycles until the new mode is commanded
  std::uint32_t shown_ = 0;      ///< consecutive exchanges that showed the wanted mode
  cia402::Mode from_{};          ///< mode at the start of the change
  Phase phase_ = Phase::kNone;
  bool first_ = false;         ///< this is the first cycle of the change
  bool heard_ = false;         ///< the drive has received the command to change
  bool fed_ = false;           ///< feed_velocity_ has reached that of the reference
  bool leading_ = false;       ///< the change started in CSP, and the drive has not left it
  bool on_setpoints_ = false;  ///< the reference is the setpoint
};

}  // namespace driveline::motion
