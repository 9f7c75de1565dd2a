#pragma once

#include <chrono>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/msd/fine_interpolator.hpp"
#include "driveline/slaves/msd/scaling.hpp"
#include "driveline/slaves/plant/servo_controller.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves::msd {

/// What the object dictionary tells the motion control, in motor units.
struct MotionSettings {
  Scaling scaling;
  ControllerParameters controller;
  FineInterpolator::Method method = FineInterpolator::Method::kLinear;
  std::uint32_t steps_per_setpoint = 16;
  double speed_feed_forward = 1.0;   ///< share, 0..1
  double torque_feed_forward = 1.0;  ///< share, 0..1
  bool external_speed_feed_forward = false;
  bool external_torque_feed_forward = false;
  double feed_forward_inertia_kg_m2 = 0.0;  ///< 0: no internal torque feed-forward
  double slow_down_rad_s2 = 600.0;
  double quick_stop_rad_s2 = 2500.0;
  double standstill_rad_s = 1.0;
  bool position_limited = false;  ///< software limits 607Dh, in position units
  std::int32_t position_min = 0;
  std::int32_t position_max = 0;
};

/// Setpoints as they stand in the object dictionary, in user units.
struct Setpoints {
  std::int32_t position = 0;
  std::int32_t velocity = 0;
  std::int16_t torque_permille = 0;
  std::int32_t velocity_offset = 0;
  std::int16_t torque_offset_permille = 0;
};

/// Motor, controller and the setpoints between them: follows the cyclic modes, brakes on ramps, coasts. One object
/// per axis; step() runs once per control cycle of 62.5 us.
class Motion {
 public:
  Motion(const MotorParameters& motor, double initial_position_rad) noexcept;

  /// \rtsafe
  void configure(const MotionSettings& settings) noexcept;
  /// New setpoints from the bus; they start a segment of the fine interpolation. \rtsafe
  void set(const Setpoints& setpoints) noexcept;
  /// One control cycle. A change of command or mode takes over position, speed and torque as they are. \rtsafe
  void step(MotionCommand command, OperationMode mode) noexcept;

  [[nodiscard]] const ServoMotor& motor() const noexcept { return motor_; }
  [[nodiscard]] const ServoController& controller() const noexcept { return controller_; }
  /// Position in position units, not wrapped to 32 bits. \rtsafe
  [[nodiscard]] std::int64_t position() const noexcept;
  [[nodiscard]] double position_demand() const noexcept;  ///< position units; actual position unless in CSP
  [[nodiscard]] double following_error() const noexcept;  ///< position units; 0 unless in CSP
  [[nodiscard]] double velocity() const noexcept;         ///< velocity units
  [[nodiscard]] double velocity_demand() const noexcept;  ///< velocity units
  [[nodiscard]] double torque_permille() const noexcept;
  [[nodiscard]] double torque_demand_permille() const noexcept;
  /// The measured speed is within the standstill window. \rtsafe
  [[nodiscard]] bool standstill() const noexcept;
  /// Standstill, and a braking ramp has come to its end. \rtsafe
  [[nodiscard]] bool stopped() const noexcept { return standstill() && !(ramp_rad_s_ < 0.0 || ramp_rad_s_ > 0.0); }
  /// Torque, velocity or position setpoint was limited. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return limited_ || controller_.limited(); }
  /// Distance of actual position or speed from the setpoint of the mode, in its units; 0 in torque mode. \rtsafe
  [[nodiscard]] double distance_to_target() const noexcept;

 private:
  void take_over(MotionCommand command, OperationMode mode) noexcept;
  void push_setpoints() noexcept;
  [[nodiscard]] double measured_position_rad() const noexcept;
  [[nodiscard]] double follow() noexcept;
  [[nodiscard]] double follow_position() noexcept;
  [[nodiscard]] double follow_velocity() noexcept;
  [[nodiscard]] double follow_torque() noexcept;
  [[nodiscard]] double brake(double deceleration_rad_s2) noexcept;
  [[nodiscard]] double speed_feed_forward(double internal_rad_s) const noexcept;
  [[nodiscard]] double torque_feed_forward(double acceleration_rad_s2) const noexcept;
  [[nodiscard]] double torque_of(double permille) const noexcept;

  ServoMotor motor_;
  ServoController controller_;
  MotionSettings settings_;
  Setpoints setpoints_;
  FineInterpolator position_;
  FineInterpolator velocity_;
  FineInterpolator torque_;
  MotionCommand command_ = MotionCommand::kOff;
  OperationMode mode_ = OperationMode::kNone;
  std::int64_t target_position_ = 0;  ///< 607Ah without the wrap at 32 bits
  double units_per_increment_ = 1.0;
  double ramp_rad_s_ = 0.0;
  double torque_demand_nm_ = 0.0;
  bool limited_ = false;
};

}  // namespace driveline::slaves::msd
