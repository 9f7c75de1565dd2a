#pragma once

#include <chrono>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/cia402/profile_generator.hpp"
#include "driveline/slaves/cia402/ratio.hpp"
#include "driveline/slaves/msd/core/fine_interpolator.hpp"
#include "driveline/slaves/msd/core/scaling.hpp"
#include "driveline/slaves/plant/servo_controller.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves::msd {

/// Settings of the motion control from the object dictionary, in motor units.
struct MotionSettings {
  double standstill_rad_s = 1.0;            ///< below this speed the axis counts as at standstill
  double torque_per_demand = 1.0;           ///< actual torque per torque by P 457 and P 460; 1 if these match the motor
  double speed_feed_forward = 1.0;          ///< share, 0..1
  double torque_feed_forward = 1.0;         ///< share, 0..1
  double feed_forward_inertia_kg_m2 = 0.0;  ///< 0: no internal torque feed-forward
  bool external_speed_feed_forward = false;                             ///< 60B1h is the speed feed-forward
  bool external_torque_feed_forward = false;                            ///< 60B2h is the torque feed-forward
  bool position_limited = false;                                        ///< software limits 607Dh, in position units
  FineInterpolator::Method method = FineInterpolator::Method::kLinear;  ///< P 370
  bool cycle_by_objects = true;           ///< P 306 and 60C2h have to agree on the cycle of the setpoints
  std::uint32_t steps_per_setpoint = 16;  ///< control cycles per setpoint of the bus (60C2h), at least 1
  double rated_torque_nm = 2.4;           ///< P 460, equals 1000 per mille of torque
  PositionRangeLimit range;               ///< position range (607Bh)
  Scaling scaling;                        ///< user units, see Scaling
  std::int32_t position_min = 0;          ///< 607Dh:01, position units
  std::int32_t position_max = 0;          ///< 607Dh:02, position units
  double rated_current_a = 2.5;           ///< P 457, RMS value, equals 1000 per mille of current
  double slow_down_rad_s2 = 600.0;        ///< 6084h
  double quick_stop_rad_s2 = 2500.0;      ///< 6085h
  double jerk_time_s = 0.0;         ///< jerk time of profile and quick stop ramps, not of fault ramps (MSD manual 10.2)
  ControllerParameters controller;  ///< P 320, P 321, P 351, P 360, 6072h, 6080h
  VoltageFrequencyParameters voltage_frequency;  ///< U/f characteristic of mode 2
};

/// Setpoints of the bus, at the motor shaft; positions in position units, so that they wrap around exactly.
struct Setpoints {
  std::int32_t position = 0;           ///< whole position units
  double position_fraction = 0.0;      ///< fraction of a position unit, 0 to 1, which is added to `position`
  double velocity_rad_s = 0.0;         ///< velocity
  double torque_nm = 0.0;              ///< torque
  double velocity_offset_rad_s = 0.0;  ///< added to the velocity as feed-forward
  double torque_offset_nm = 0.0;       ///< added to the torque as feed-forward
};

/// Source of the setpoints for MotionCommand::kFollow.
enum class MotionSource : std::uint8_t {
  kNone,              ///< no mode: speed zero
  kCyclicPosition,    ///< setpoints of the bus, fine interpolation, position control
  kCyclicVelocity,    ///< setpoints of the bus, fine interpolation, velocity control
  kCyclicTorque,      ///< setpoints of the bus, fine interpolation, torque control
  kProfilePosition,   ///< profile generator, position control
  kProfileVelocity,   ///< profile generator, velocity control
  kProfileFrequency,  ///< profile generator, U/f operation
};

/// Motor, controller and the setpoints between them: follows setpoints or its profile generator, brakes on ramps,
/// coasts. One object per axis; step() runs once per control cycle of 62.5 us.
class DriveMotion {
 public:
  /// Starts at rest at `initial_position_rad`, with command kOff; parameters as in ServoMotor.
  DriveMotion(const MotorParameters& motor, double initial_position_rad) noexcept;

  /// Applies new settings from the next control cycle on, also in motion. \rtsafe
  void configure(const MotionSettings& settings) noexcept;
  /// Sets shares of the feed-forward and the deceleration of MotionCommand::kSlowDownRamp until the next configure(),
  /// for profiles whose modes differ in these; a ramp in progress keeps its deceleration. \rtsafe
  void adapt(double speed_feed_forward, double torque_feed_forward, double slow_down_rad_s2) noexcept {
    settings_.speed_feed_forward = speed_feed_forward;
    settings_.torque_feed_forward = torque_feed_forward;
    settings_.slow_down_rad_s2 = slow_down_rad_s2;
  }
  /// Sets new setpoints of the bus; the setpoint of the active source starts a segment of its interpolation. \rtsafe
  void set(const Setpoints& setpoints) noexcept;
  /// Sets the setpoints that the next change of the source takes over; offsets take effect at once. \rtsafe
  void prepare(const Setpoints& setpoints) noexcept { setpoints_ = setpoints; }
  /// Starts a movement of the profile generator to a position in position units (not wrapped). Limits are in motor
  /// units. It lasts until the next movement or change of the source. \rtsafe
  void move_to(std::int64_t position, const GeneratorLimits& limits) noexcept;
  /// Starts a movement that reaches and keeps this speed of the motor shaft; otherwise like move_to().
  void run_at(double velocity_rad_s, const GeneratorLimits& limits) noexcept;
  /// Decelerates to standstill with 6084h; ends any movement. \rtsafe
  void stand() noexcept;
  /// Holds the current speed of the profile generator. \rtsafe
  void freeze() noexcept;
  /// Sets command and source. A change takes over the present position, speed and torque, and ends a movement of the
  /// profile generator. `smooth`: braking ramps have the profile's jerk time. \rtsafe
  void select(MotionCommand command, MotionSource source, bool smooth) noexcept;
  /// Runs one control cycle. \rtsafe
  void step(bool brake_closed) noexcept;
  /// Power-on of an encoder that does not know all turns: positions are relative to its start position. \rtsafe
  void restart_encoder() noexcept;
  /// Sets the DC link voltage; see ServoMotor::set_dc_link_voltage(). \rtsafe
  void set_dc_link_voltage(double volts) noexcept { motor_.set_dc_link_voltage(volts); }
  /// Returns the motor, for external influences. \rtsafe
  [[nodiscard]] ServoMotor& motor() noexcept { return motor_; }
  /// Returns the power that the power stage takes from the DC link. \rtsafe
  [[nodiscard]] double power_w() const noexcept { return command_ == MotionCommand::kOff ? 0.0 : motor_.power_w(); }
  /// Returns the current amplitude that the power stage drives, limited by this DC link voltage. \rtsafe
  [[nodiscard]] double phase_current_a(double dc_link_volts) const noexcept;
  /// Makes `increments` of the encoder the new zero of all positions; does not affect the movement. \rtsafe
  void set_zero(std::int64_t increments) noexcept;

  /// Returns the motor with the actual state of the shaft. \rtsafe
  [[nodiscard]] const ServoMotor& motor() const noexcept { return motor_; }
  /// Returns the control cascade. \rtsafe
  [[nodiscard]] const ServoController& controller() const noexcept { return controller_; }
  /// Returns the settings of the last configure(). \rtsafe
  [[nodiscard]] const MotionSettings& settings() const noexcept { return settings_; }
  /// Returns the encoder count of position 0. \rtsafe
  [[nodiscard]] std::int64_t zero() const noexcept { return zero_; }
  /// Returns the position in position units, not wrapped to 32 bits. \rtsafe
  [[nodiscard]] std::int64_t position() const noexcept { return position_at(motor_.encoder_count()); }
  /// Returns the position of an encoder count in position units, not wrapped to 32 bits. \rtsafe
  [[nodiscard]] std::int64_t position_at(std::int64_t increments) const noexcept {
    return settings_.scaling.to_units(increments - zero_);
  }
  /// Returns the position setpoint in position units; the actual position without position control. \rtsafe
  [[nodiscard]] double position_demand() const noexcept {
    if (!position_controlled()) return static_cast<double>(position());
    return (position_setpoint_rad() - to_rad(0.0)) / settings_.scaling.position_rad;
  }
  /// Returns the following error in position units; 0 without position control. \rtsafe
  [[nodiscard, gnu::cold]] double following_error() const noexcept;
  /// Whether the magnitude of following_error() is above this number of position units. \rtsafe
  [[nodiscard]] bool following_error_above(std::uint32_t units) const noexcept {
    if (!position_controlled()) return false;
    // Positions are whole units, so the exact error differs by less than two of them.
    const double rad = std::abs(position_setpoint_rad() - measured_position_rad());
    if (rad < (units - 2.0) * std::abs(settings_.scaling.position_rad)) return false;
    return std::abs(following_error()) > units;
  }
  /// Returns the following error in encoder increments; 0 without position control. \rtsafe
  [[nodiscard]] double following_error_increments() const noexcept;
  /// Returns the speed feed-forward that the bus sends (60B1h), even if it is not used. \rtsafe
  [[nodiscard]] double external_velocity_rad_s() const noexcept { return setpoints_.velocity_offset_rad_s; }
  /// Returns the torque feed-forward that the bus sends (60B2h), even if it is not used.
  [[nodiscard]] double external_torque_nm() const noexcept { return setpoints_.torque_offset_nm; }
  /// Returns the motor torque, calculated with P 457 and P 460. \rtsafe
  [[nodiscard]] double torque_nm() const noexcept { return motor_.torque_nm() / settings_.torque_per_demand; }
  /// Returns the torque setpoint of the last control cycle, calculated with P 457 and P 460. \rtsafe
  [[nodiscard]] double torque_demand_nm() const noexcept { return torque_demand_nm_; }
  [[nodiscard]] double velocity() const noexcept;         ///< velocity units
  [[nodiscard]] double velocity_demand() const noexcept;  ///< velocity units
  /// Whether the motor is in U/f operation. \rtsafe
  [[nodiscard]] bool by_frequency() const noexcept { return by_frequency_; }
  /// Whether the measured speed has been within the standstill window for 4 ms. \rtsafe
  [[nodiscard]] bool standstill() const noexcept { return slow_steps_ == kStandstillSteps; }
  /// Whether the axis is at standstill and a braking ramp, if any, has ended. \rtsafe
  [[nodiscard]] bool stopped() const noexcept { return standstill() && (!ramping_ || generator_.finished()); }
  /// Whether the movement of the profile generator has ended. \rtsafe
  [[nodiscard]] bool movement_finished() const noexcept { return generator_.finished(); }
  /// Returns the state of the profile generator in radians of the motor shaft. \rtsafe
  [[nodiscard]] const ProfileState& profile() const noexcept { return generator_.state(); }
  /// Whether a torque, velocity or position setpoint was limited. \rtsafe
  [[nodiscard]] bool limited() const noexcept {
    return limited_ || controller_.limited() || (by_frequency_ && frequency_control_.limited());
  }
  /// Returns the distance of position or speed from the source's setpoint, in its units; 0 in torque control. \rtsafe
  [[nodiscard]] double distance_to_target() const noexcept {
    if (source_ == MotionSource::kCyclicPosition) return static_cast<double>(target_position_ - position());
    return distance_to_speed();
  }
  /// Whether the last setpoints arrived at the times that the interpolation expects. \rtsafe
  [[nodiscard]] bool synchronised() const noexcept {
    return samples_on_time_ == kSamplesForSynchronism && steps_since_sample_ <= settings_.steps_per_setpoint + 1;
  }
  /// Returns the source of the last select(). \rtsafe
  [[nodiscard]] MotionSource source() const noexcept { return source_; }
  /// Returns the command of the last select(). \rtsafe
  [[nodiscard]] MotionCommand command() const noexcept { return command_; }
  /// Whether the axis follows setpoints that come in the cycle of the bus. \rtsafe
  [[nodiscard]] bool follows_cyclic_setpoints() const noexcept {
    return command_ == MotionCommand::kFollow &&
           (source_ == MotionSource::kCyclicPosition || source_ == MotionSource::kCyclicVelocity ||
            source_ == MotionSource::kCyclicTorque);
  }
  /// Returns the direction in user units in which the setpoints move the axis: -1, 0, 1; without speed control, the
  /// direction of the actual motion. \rtsafe
  [[nodiscard]] int direction() const noexcept;

 private:
  static constexpr std::uint32_t kSamplesForSynchronism = 8;  ///< setpoints on time; ours
  static constexpr std::uint32_t kStandstillSteps = 64;       ///< 4 ms within the window of P 745; ours

  [[nodiscard]] ProfileState motion_in_force() const noexcept;
  [[nodiscard]] double distance_to_speed() const noexcept;
  [[nodiscard]] bool slow() const noexcept;
  [[nodiscard]] double inertia() const noexcept;  ///< inertia that the torque moves, as known to the drive
  [[nodiscard]] double ramp_rad_s2() const noexcept;
  void run_ramp() noexcept;
  void start_limit_stop() noexcept;
  [[nodiscard]] double stop_at_limit() noexcept;
  void take_over(MotionCommand command, MotionSource source, bool smooth) noexcept;
  void start_frequency_control() noexcept;
  void step_frequency_control(bool brake_closed) noexcept;
  void push_setpoints() noexcept;
  [[nodiscard]] bool position_controlled() const noexcept {
    return command_ == MotionCommand::kFollow &&
           (source_ == MotionSource::kCyclicPosition || source_ == MotionSource::kProfilePosition);
  }
  [[nodiscard]] double position_setpoint_rad() const noexcept {
    return source_ == MotionSource::kCyclicPosition ? position_.value() : generator_.state().position;
  }
  [[nodiscard]] double measured_position_rad() const noexcept {
    return static_cast<double>(motor_.encoder_count()) * motor_.radians_per_increment();
  }
  /// Converts position units to radians of the motor shaft.
  [[nodiscard]] double to_rad(double position) const noexcept {
    return position * settings_.scaling.position_rad + static_cast<double>(zero_) * motor_.radians_per_increment();
  }
  [[nodiscard]] double obey() noexcept;
  [[nodiscard]] double follow() noexcept;
  [[nodiscard]] double follow_position() noexcept;
  [[nodiscard]] double follow_velocity() noexcept;
  [[nodiscard]] double follow_torque() noexcept;
  [[nodiscard]] double follow_profile_position() noexcept;
  [[nodiscard]] double follow_profile_velocity() noexcept;
  [[nodiscard]] double speed_towards_setpoint(double speed, std::uint32_t since) const noexcept;
  [[nodiscard]] double speed_feed_forward(double internal_rad_s) const noexcept;
  [[nodiscard]] double torque_feed_forward(double acceleration_rad_s2) const noexcept;
  [[nodiscard]] double internal_torque(double acceleration_rad_s2) const noexcept;

  ServoMotor motor_;
  ServoController controller_;
  // What a drive that follows cyclic positions uses is together, so that it shares few cache lines.
  MotionCommand command_ = MotionCommand::kOff;
  MotionSource source_ = MotionSource::kNone;
  bool by_frequency_ = false;  ///< U/f operation, including the ramp that ends it
  bool limited_ = false;
  bool ramping_ = false;
  std::uint32_t slow_steps_ = 0;  ///< control cycles within the standstill window
  std::uint32_t samples_on_time_ = 0;
  std::uint32_t steps_since_sample_ = 0;
  double torque_demand_nm_ = 0.0;
  std::int64_t zero_ = 0;
  std::int64_t target_position_ = 0;   ///< cyclic position setpoint, not wrapped to 32 bits
  std::int64_t allowed_position_ = 0;  ///< target_position_ within the software limits
  Setpoints setpoints_;
  MotionSettings settings_;
  FineInterpolator position_;
  FineInterpolator velocity_;
  FineInterpolator torque_;
  ProfileGenerator generator_;
  VoltageFrequency frequency_control_;
  double stop_velocity_rad_s_ = 0.0;
  double ramp_jerk_time_s_ = 0.0;
};

}  // namespace driveline::slaves::msd
