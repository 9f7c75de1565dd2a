#pragma once

#include <cstdint>
#include <memory>

#include "driveline/motion/axis/setpoint_delay.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/position_correction.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::motion {

/// Pitch error and backlash between a drive and its axis, and the motion that takes up the backlash.
struct CompensationSettings {
  trajectory::PositionCorrection correction;  ///< in axis positions
  double take_up_velocity = 0.0;              ///< velocity added to the drive, rad/s or m/s; above 0
  double take_up_acceleration = 0.0;          ///< rad/s^2 or m/s^2; above 0
  /// The compensation starts with homing (AxisCommand::kHome, kHomeByProbe) and uses the positions that homing defines:
  /// positions of the drive have no meaning before.
  bool when_homed = false;
};

/// Limits that remain for motions of an axis when the compensation is added, so that the demand keeps the limits of the
/// drive: accounts for the steepest slope, the highest curvature and a simultaneous take-up of the backlash. A value
/// that is not above zero means that nothing remains.
[[nodiscard]] trajectory::AxisLimits limits_of_motion(const trajectory::AxisLimits& drive,
                                                      const CompensationSettings& compensation) noexcept;

/// Converts setpoints of an axis to those of its drive, and the actual position of the drive to that of the axis, so
/// that the rest of the master counts in axis positions. The direction is that of the setpoints; when it changes, the
/// backlash is taken up by a separate motion with limited velocity, acceleration and jerk.
///
/// Used by the cycle thread only; everything except the constructor is \rtsafe.
class AxisCompensation {
 public:
  /// `settings` must not be null. `delay_cycles`: cycles between a setpoint and the actual position that belongs to it.
  /// `increment`: size of an increment of the drive, rad or m.
  AxisCompensation(std::shared_ptr<const CompensationSettings> settings, double period_s, double delay_cycles,
                   double increment);

  /// Whether the compensation waits for homing.
  [[nodiscard]] bool when_homed() const noexcept { return settings_->when_homed; }
  /// Starts the compensation after homing by the drive: its positions are those of the table.
  void begin() noexcept;
  /// Axis positions as they count after begin().
  struct Renamed {
    double mark = 0.0;      ///< rad or m
    double setpoint = 0.0;  ///< position commanded to the drive, rad or m
  };
  /// Starts the compensation after homing by the master: the position `mark`, passed in this direction, is named
  /// `called`.
  [[nodiscard]] Renamed begin(double mark, double called, bool forward, double setpoint) noexcept;

  // Conversion of measured values of the drive to the axis.
  /// Selects the backlash state that belongs to the actual position. `delayed`: the drive closes the position loop and
  /// follows setpoints of some cycles ago.
  void update(bool delayed) noexcept;
  /// Axis position for a position of the drive, as of the last update(); rad or m.
  [[nodiscard]] double axis_position(double drive) const noexcept;
  /// Axis velocity for a velocity of the drive at `axis_position`; rad/s or m/s.
  [[nodiscard]] double axis_velocity(double drive_velocity, double axis_position) const noexcept;

  // Conversion of commanded values of the axis to the drive.
  /// Takes the setpoint of this cycle: updates the direction and the take-up of the backlash.
  void advance(double setpoint) noexcept;
  /// To be called while the axis does not move by setpoints: no backlash is taken up, and a take-up in progress stops
  /// where it is.
  void rest() noexcept;
  /// Accounts for `periods` periods without advance() or rest(); a take-up in progress has continued.
  void skip(std::int64_t periods) noexcept;
  /// Commanded position of the drive and the terms of its velocity.
  struct DriveTarget {
    double position = 0.0;  ///< rad or m
    double slope = 1.0;     ///< velocity of the drive per velocity of the axis
    double velocity = 0.0;  ///< velocity added by the take-up of the backlash, rad/s or m/s
  };
  /// Values for the drive at an axis setpoint, as of the last advance() or rest().
  [[nodiscard]] DriveTarget drive_target(double axis_position) const noexcept;

 private:
  enum class Direction : std::uint8_t { kNone, kForward, kBackward };

  [[nodiscard]] bool in_force() const noexcept { return homed_ || !settings_->when_homed; }
  void turn(Direction direction) noexcept;
  void step() noexcept;
  void remember() noexcept;

  std::shared_ptr<const CompensationSettings> settings_;
  double period_s_;
  double reversal_;     ///< reverse motion that counts as a change of direction, rad or m
  bool homed_ = false;  ///< set by begin()
  double shift_ = 0.0;  ///< table position minus axis position, rad or m
  Direction direction_ = Direction::kForward;
  double lowest_ = 0.0;  ///< lowest setpoint since the last change of direction
  double highest_ = 0.0;
  bool tracking_ = false;  ///< lowest_ and highest_ are valid
  bool turning_ = false;   ///< the backlash is being taken up
  trajectory::Profile profile_{};
  double elapsed_s_ = 0.0;
  trajectory::AxisSetpoint side_{1.0, 0.0, 0.0};  ///< PositionCorrection's `forward`, 0 to 1, and its velocity
  trajectory::AxisSetpoint seen_{1.0, 0.0, 0.0};  ///< value of side_ that belongs to the actual position
  SetpointHistory sides_;
  SetpointHistory side_velocities_;
};

}  // namespace driveline::motion
