#pragma once

#include <cstdint>
#include <memory>

#include "driveline/ecat_master/axis/setpoint_delay.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/position_correction.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::ecat_master {

/// Pitch error and backlash between a drive and its axis, and how the backlash is taken up.
struct CompensationSettings {
  trajectory::PositionCorrection correction;  ///< in the positions of the axis
  double take_up_velocity = 0.0;              ///< of the drive, rad/s or m/s; above 0
  double take_up_acceleration = 0.0;          ///< rad/s^2 or m/s^2; above 0
  /// Only from homing on (AxisCommand::kHome, kHomeByProbe), and in the positions that it gives: those of the drive
  /// mean nothing before.
  bool when_homed = false;
};

/// What is left of the limits of a drive for the motions of its axis, so that its demand keeps them with the
/// compensation on top: with the steepest slope, the highest curvature, and the backlash taken up meanwhile. Not above
/// zero: nothing is left.
[[nodiscard]] trajectory::AxisLimits limits_of_motion(const trajectory::AxisLimits& drive,
                                                      const CompensationSettings& compensation) noexcept;

/// Stands between the setpoints of an axis and its drive, and between the actual position of the drive and that of the
/// axis: the rest of the master counts as the axis does. The direction is that of the setpoints; where it changes, the
/// backlash is taken up by a motion of its own with limited velocity, acceleration and jerk.
///
/// Belongs to the cycle; everything but the constructor is \rtsafe.
class AxisCompensation {
 public:
  /// `settings` is not null. `delay_cycles`: from a setpoint to the actual position that belongs to it. `increment`: of
  /// the drive, rad or m.
  AxisCompensation(std::shared_ptr<const CompensationSettings> settings, double period_s, double delay_cycles,
                   double increment);

  /// Whether it has to wait for homing.
  [[nodiscard]] bool when_homed() const noexcept { return settings_->when_homed; }
  /// The drive has homed: its positions are those of the table.
  void begin() noexcept;
  /// Positions of the axis, as they count from begin() on.
  struct Renamed {
    double mark = 0.0;      ///< rad or m
    double setpoint = 0.0;  ///< where the drive is told to be, rad or m
  };
  /// The master has homed: at its position `mark`, which it has passed in this direction, the axis is called `called`.
  [[nodiscard]] Renamed begin(double mark, double called, bool forward, double setpoint) noexcept;

  // What the drive measures, as the axis counts.
  /// Actual position and what else belongs to it; `delayed`: the drive closes the position loop, and follows setpoints
  /// of some cycles ago.
  void look(bool delayed) noexcept;
  /// As of the last look(). rad or m
  [[nodiscard]] double axis_position(double drive) const noexcept;
  /// At that position of the drive. rad/s or m/s
  [[nodiscard]] double axis_velocity(double drive_velocity, double axis_position) const noexcept;

  // What the drive is told.
  /// The setpoint of this cycle: the direction, and the backlash.
  void advance(double setpoint) noexcept;
  /// The axis does not move by setpoints: nothing is taken up, and where that was under way it stays as the axis is.
  void rest() noexcept;
  /// So many periods have gone by without one: what is under way has gone on.
  void skip(std::int64_t periods) noexcept;
  /// Where the drive must be, and how fast it goes per velocity of the axis, and beside it.
  struct Told {
    double position = 0.0;  ///< rad or m
    double slope = 1.0;     ///< velocity of the drive per velocity of the axis
    double velocity = 0.0;  ///< by the backlash that is taken up, rad/s or m/s
  };
  /// For a setpoint of the axis, as of the last advance() or rest().
  [[nodiscard]] Told told(double axis_position) const noexcept;

 private:
  enum class Direction : std::uint8_t { kNone, kForward, kBackward };

  [[nodiscard]] bool in_force() const noexcept { return homed_ || !settings_->when_homed; }
  void turn(Direction direction) noexcept;
  void step() noexcept;
  void remember() noexcept;

  std::shared_ptr<const CompensationSettings> settings_;
  double period_s_;
  double reversal_;     ///< way back that counts as another direction, rad or m
  bool homed_ = false;  ///< begin()
  double shift_ = 0.0;  ///< positions of the table are those of the axis plus this
  Direction direction_ = Direction::kForward;
  double lowest_ = 0.0;  ///< setpoint since the direction has changed
  double highest_ = 0.0;
  bool tracking_ = false;  ///< they are known
  bool turning_ = false;   ///< the backlash is being taken up
  trajectory::Profile profile_{};
  double elapsed_s_ = 0.0;
  trajectory::AxisSetpoint side_{1.0, 0.0, 0.0};  ///< PositionCorrection's `forward`, and its velocity
  trajectory::AxisSetpoint seen_{1.0, 0.0, 0.0};  ///< that of the actual position
  SetpointHistory sides_;
  SetpointHistory side_velocities_;
};

}  // namespace driveline::ecat_master
