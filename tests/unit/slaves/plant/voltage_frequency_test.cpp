// U/f operation of a synchronous motor: synchronism, load angle, pull-out, damping, current limit, take-over.
#include "driveline/slaves/plant/voltage_frequency.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves {
namespace {

constexpr double kStep = 62.5e-6;

/// A motor on a voltage, with a weight as its load.
class Bench {
 public:
  explicit Bench(double load_nm, MotorParameters parameters = {}) : motor_(with_load(parameters, load_nm), kStep, 0.0) {
    control_.configure(motor_.rated_characteristic());
    motor_.drive_by_voltage(true);
    const double angle = motor_.current_loop().voltage_angle_rad(control_.characteristic_v(0.0), 0.0, 0.0);
    control_.start({}, angle, 0.0);
  }
  /// Takes the frequency to this speed of the shaft at `acceleration`, and stays there for `rest_s`.
  void run(double speed_rad_s, double rest_s, double acceleration = 200.0) {
    const double direction = speed_rad_s > speed_ ? 1.0 : -1.0;
    for (int rest = static_cast<int>(rest_s / kStep); rest > 0;) {
      speed_ += direction * acceleration * kStep;
      if ((speed_ - speed_rad_s) * direction >= 0.0) {
        speed_ = speed_rad_s;
        --rest;
      }
      step();
    }
  }
  void step() {
    const CurrentLoop& current = motor_.current_loop();
    const double electrical = motor_.parameters().pole_pairs * speed_;
    vector_ = control_.step(electrical, {current.current_a(), current.active_current_a()});
    angle_ = vector_.angle_rad - motor_.electrical_angle_rad();
    motor_.step(vector_, false);
    highest_current_ = std::max(highest_current_, current.current_a());
  }
  /// Largest difference of the shaft's speed from the frequency in this time.
  double swing(double time_s) {
    double most = 0.0;
    for (int i = 0; i < static_cast<int>(time_s / kStep); ++i) {
      step();
      most = std::max(most, std::abs(motor_.velocity_rad_s() - speed_));
    }
    return most;
  }
  /// Electrical angle between voltage and d axis.
  [[nodiscard]] double angle() const { return angle_; }
  /// The highest torque at this speed.
  [[nodiscard]] double pull_out_nm(double speed_rad_s) const {
    const double volts = control_.characteristic_v(motor_.parameters().pole_pairs * speed_rad_s);
    double torque = 0.0;
    const auto at_limit = [&](double nm) {
      return std::abs(motor_.current_loop().voltage_angle_rad(volts, nm, speed_rad_s) -
                      motor_.current_loop().voltage_angle_rad(volts, 1e9, speed_rad_s)) < 1e-9;
    };
    while (!at_limit(torque)) torque += 0.001;
    return torque;
  }
  [[nodiscard]] const ServoMotor& motor() const { return motor_; }
  [[nodiscard]] VoltageFrequency& control() { return control_; }
  double highest_current_ = 0.0;

 private:
  static MotorParameters with_load(MotorParameters parameters, double load_nm) {
    parameters.load.gravity_nm = load_nm;
    return parameters;
  }
  ServoMotor motor_;
  VoltageFrequency control_{kStep};
  VoltageVector vector_;
  double angle_ = 0.0;
  double speed_ = 0.0;
};

TEST(VoltageFrequency, CharacteristicIsAStraightLineFromBoostToNominal) {
  VoltageFrequency control(kStep);
  control.configure({.boost_v = 10.0, .nominal_v = 110.0, .nominal_hz = 50.0});
  const auto at = [&](double hz) { return control.characteristic_v(2.0 * std::numbers::pi * hz); };
  EXPECT_DOUBLE_EQ(at(0.0), 10.0);
  EXPECT_DOUBLE_EQ(at(25.0), 60.0);
  EXPECT_DOUBLE_EQ(at(-25.0), 60.0);
  EXPECT_DOUBLE_EQ(at(50.0), 110.0);
  EXPECT_DOUBLE_EQ(at(80.0), 110.0) << "voltage stays, the field weakens";
}

TEST(VoltageFrequency, TheRotorIsSynchronousAtEverySpeedWithAndWithoutLoad) {
  for (const double inertia : {1e-4, 3e-4, 3e-3}) {
    for (const double speed : {5.0, 20.0, 50.0, 100.0, 200.0, 400.0, 600.0, -5.0, -100.0, -300.0, -600.0}) {
      for (const double load : {0.0, 0.8, -0.8}) {
        MotorParameters parameters;
        parameters.inertia_kg_m2 = inertia;
        Bench bench(load, parameters);
        bench.run(speed, 1.0, inertia > 1e-3 ? 60.0 : 200.0);
        EXPECT_LT(bench.swing(0.2), 0.3) << speed << " rad/s, " << load << " Nm, " << inertia << " kg m2";
      }
    }
  }
}

TEST(VoltageFrequency, LoadAngleIsThatOfTheSettledCircuit) {
  for (const double speed : {30.0, 150.0, 500.0}) {
    double last = -10.0;
    for (const double load : {-1.0, 0.0, 1.0, 1.5}) {
      MotorParameters parameters;
      parameters.coulomb_friction_nm = 0.0;
      parameters.viscous_friction_nm_s = 0.0;
      Bench bench(load, parameters);
      bench.run(speed, 1.5);
      const double volts = bench.control().characteristic_v(4.0 * speed);
      const double expected = bench.motor().current_loop().voltage_angle_rad(volts, load, speed);
      EXPECT_NEAR(bench.angle(), expected, 0.01) << speed << " rad/s, " << load << " Nm";
      EXPECT_NEAR(bench.motor().torque_nm(), load, 0.01);
      EXPECT_GT(bench.angle(), last) << "more load, more angle";
      last = bench.angle();
    }
  }
}

TEST(VoltageFrequency, PullsOutJustAboveTheTorqueTheCircuitCanGive) {
  MotorParameters parameters;
  parameters.coulomb_friction_nm = 0.0;
  parameters.viscous_friction_nm_s = 0.0;
  const double most = Bench(0.0, parameters).pull_out_nm(60.0);
  EXPECT_GT(most, 2.0);
  EXPECT_LT(most, 7.2);
  const auto mean_speed = [&](double share) {
    Bench bench(0.0, parameters);
    bench.run(60.0, 0.5);
    // The same speed and angle with the load, which is applied slowly, like a weight lowered onto a hook.
    const double start = bench.motor().position_rad();
    for (int i = 0; i < 16000; ++i) bench.step();
    EXPECT_NEAR(bench.motor().position_rad() - start, 60.0, 0.1);
    Bench loaded(share * most, parameters);
    loaded.run(60.0, 1.0, 30.0);
    const double from = loaded.motor().position_rad();
    for (int i = 0; i < 16000; ++i) loaded.step();
    return loaded.motor().position_rad() - from;
  };
  EXPECT_NEAR(mean_speed(0.6), 60.0, 0.1);
  EXPECT_LT(mean_speed(1.15), 0.0) << "the weight falls";
}

/// A long time at the limit: the current stays close to it, whatever the rotor does.
TEST(VoltageFrequency, VoltageGivesWayAtTheCurrentLimit) {
  Bench bench(0.0);
  auto characteristic = bench.motor().rated_characteristic();
  characteristic.boost_v *= 10.0;  // eight times the rated current, if it were allowed
  characteristic.max_current_a = 6.0;
  bench.control().configure(characteristic);
  bench.run(0.0, 0.2);
  EXPECT_TRUE(bench.control().limited());
  EXPECT_LT(bench.highest_current_, 6.0 * 1.5) << "while it rises";
  bench.highest_current_ = 0.0;
  bench.run(0.0, 0.5);
  EXPECT_LT(bench.highest_current_, 6.0 * 1.1);
  EXPECT_GT(bench.highest_current_, 6.0 * 0.9);
  characteristic.boost_v *= 0.05;
  bench.control().configure(characteristic);
  bench.run(0.0, 0.2);
  EXPECT_FALSE(bench.control().limited()) << "the voltage comes back";
}

TEST(VoltageFrequency, TakesOverTorqueAndSpeedWithoutAJump) {
  for (const bool windings : {false, true}) {
    for (const double speed : {0.0, 40.0, -150.0, 450.0}) {
      for (const double load : {0.0, 1.0}) {
        MotorParameters parameters;
        parameters.winding.simulated = windings;
        parameters.load.gravity_nm = load;
        parameters.coulomb_friction_nm = 0.0;
        ServoMotor motor(parameters, kStep, 0.0);
        // A speed controller of the test accelerates it and holds the speed.
        for (int i = 0; i < 40000; ++i) motor.step(load + 2e-4 * speed + 0.2 * (speed - motor.velocity_rad_s()));
        ASSERT_NEAR(motor.velocity_rad_s(), speed, 0.1);
        const double torque = motor.torque_nm();
        motor.drive_by_voltage(true);
        VoltageFrequency control(kStep);
        control.configure(motor.rated_characteristic());
        const double electrical = 4.0 * speed;
        const double rotor = motor.electrical_angle_rad();
        const CurrentLoop& current = motor.current_loop();
        control.start({current.d_voltage_v(), current.q_voltage_v(), rotor},
                      rotor + current.voltage_angle_rad(control.characteristic_v(electrical), torque, speed),
                      electrical);
        double last = motor.velocity_rad_s();
        for (int i = 0; i < 8000; ++i) {
          motor.step(control.step(electrical, {current.current_a(), current.active_current_a()}), false);
          // At most 800 rad/s2, although the torque taken over would cause 3,300.
          ASSERT_NEAR(motor.velocity_rad_s(), last, 0.05) << speed << " rad/s, " << load << " Nm, step " << i;
          last = motor.velocity_rad_s();
          ASSERT_NEAR(motor.velocity_rad_s(), speed, 1.0 + 0.01 * std::abs(speed))
              << speed << " rad/s, " << load << " Nm, step " << i;
          ASSERT_NEAR(motor.torque_nm(), torque, 0.25) << speed << " rad/s, " << load << " Nm, step " << i;
        }
        motor.drive_by_voltage(false);
        const double before = motor.torque_nm();
        motor.step(before);
        EXPECT_NEAR(motor.torque_nm(), before, 0.05);
      }
    }
  }
}

}  // namespace
}  // namespace driveline::slaves
