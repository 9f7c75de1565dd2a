#include "driveline/slaves/plant/servo_motor.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace driveline::slaves {
namespace {

constexpr double kStep = 62.5e-6;

MotorParameters frictionless() {
  MotorParameters p;
  p.viscous_friction_nm_s = 0.0;
  p.coulomb_friction_nm = 0.0;
  return p;
}

TEST(ServoMotor, TorqueFollowsAsFirstOrderLag) {
  ServoMotor motor({}, kStep, 0.0);
  for (int i = 1; i <= 32; ++i) {
    motor.step(2.0);
    const double t = i * kStep;
    EXPECT_NEAR(motor.torque_nm(), 2.0 * (1.0 - std::exp(-t / motor.parameters().torque_lag_s)), 1e-12);
  }
}

TEST(ServoMotor, SpeedOfAFrictionlessMotorIsTheTorqueIntegral) {
  auto p = frictionless();
  p.torque_lag_s = 0.0;
  ServoMotor motor(p, kStep, 1.0);
  for (int i = 0; i < 1600; ++i) motor.step(0.3);  // 0.1 s
  EXPECT_NEAR(motor.velocity_rad_s(), 0.3 / p.inertia_kg_m2 * 0.1, 1e-9);
  EXPECT_NEAR(motor.position_rad(), 1.0 + 0.5 * 0.3 / p.inertia_kg_m2 * 0.01, 1e-9);
}

TEST(ServoMotor, SpeedWithViscousFrictionIsTheExponentialSolution) {
  auto p = frictionless();
  p.torque_lag_s = 0.0;
  p.viscous_friction_nm_s = 0.01;
  ServoMotor motor(p, kStep, 0.0);
  const double time_constant = p.inertia_kg_m2 / p.viscous_friction_nm_s;
  for (int i = 1; i <= 4000; ++i) {
    motor.step(1.0);
    ASSERT_NEAR(motor.velocity_rad_s(), 100.0 * (1.0 - std::exp(-i * kStep / time_constant)), 1e-9);
  }
}

TEST(ServoMotor, CoulombFrictionStopsTheShaftInFiniteTimeAndHoldsIt) {
  auto p = frictionless();
  p.torque_lag_s = 0.0;
  p.coulomb_friction_nm = 0.03;
  ServoMotor motor(p, kStep, 0.0);
  for (int i = 0; i < 16; ++i) motor.step(3.0);  // (3 - 0.03) / J for 1 ms
  const double speed = motor.velocity_rad_s();
  EXPECT_NEAR(speed, 2.97 / p.inertia_kg_m2 * 1e-3, 1e-9);
  const int steps = static_cast<int>(std::ceil(speed * p.inertia_kg_m2 / 0.03 / kStep));
  for (int i = 0; i < steps - 1; ++i) motor.step(0.0);
  EXPECT_GT(motor.velocity_rad_s(), 0.0);
  motor.step(0.0);
  EXPECT_EQ(motor.velocity_rad_s(), 0.0);
  const double position = motor.position_rad();
  for (int i = 0; i < 1000; ++i) motor.step(i % 2 == 0 ? 0.029 : -0.029);  // within the friction: sticks
  EXPECT_EQ(motor.position_rad(), position);
  for (int i = 0; i < 100; ++i) motor.step(0.031);
  EXPECT_GT(motor.velocity_rad_s(), 0.0);
}

TEST(ServoMotor, EnergyNeverGrowsWithoutTorque) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> exponent(-6.0, 1.0);
  for (int run = 0; run < 200; ++run) {
    MotorParameters p;
    p.inertia_kg_m2 = std::pow(10.0, exponent(random));
    p.viscous_friction_nm_s = std::pow(10.0, exponent(random));
    p.coulomb_friction_nm = std::pow(10.0, exponent(random));
    p.torque_lag_s = 0.0;
    ServoMotor motor(p, kStep, 0.0);
    for (int i = 0; i < 50; ++i) motor.step(run % 2 == 0 ? 7.0 : -7.0);
    double energy = motor.kinetic_energy_j();
    for (int i = 0; i < 500; ++i) {
      motor.step(0.0);
      ASSERT_LE(motor.kinetic_energy_j(), energy);
      energy = motor.kinetic_energy_j();
    }
  }
}

TEST(ServoMotor, EnergyGainIsTheWorkOfTheTorque) {
  auto p = frictionless();
  p.torque_lag_s = 0.0;
  ServoMotor motor(p, kStep, 0.0);
  double work = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double before = motor.position_rad();
    motor.step(std::sin(0.01 * i));
    work += motor.torque_nm() * (motor.position_rad() - before);
  }
  EXPECT_NEAR(motor.kinetic_energy_j(), work, 1e-9);
}

/// The standard motor's data sheet, worked out by hand in servo_motor.hpp.
TEST(ServoMotor, TorqueOverSpeedIsThatOfTheDataSheet) {
  for (const bool windings : {false, true}) {
    MotorParameters p;
    p.winding.simulated = windings;
    ServoMotor motor(p, kStep, 0.0);
    for (int i = 0; i < 160; ++i) motor.step(1e9);
    EXPECT_NEAR(motor.torque_nm(), 7.2, 0.02);
    const auto run_to = [&motor](double rad_s) {
      for (int i = 0; i < 160'000 && motor.velocity_rad_s() < rad_s; ++i) motor.step(1e9);
      return motor.torque_range().highest_nm;
    };
    EXPECT_NEAR(run_to(460.0), 7.2, 1e-9);
    EXPECT_NEAR(motor.torque_nm(), 7.2, 0.1);
    EXPECT_LT(run_to(468.0), 7.2) << "4430 rpm: the corner is at 464 rad/s";
    EXPECT_NEAR(run_to(200.0 * std::numbers::pi), 3.1, 0.05);
    EXPECT_NEAR(motor.torque_nm(), 3.1, 0.25) << "and that is what is there";
    EXPECT_NEAR(motor.torque_range().lowest_nm, -4.7, 0.05) << "braking, the resistance helps";
    run_to(1e9);
    // 323.3 V less what the friction's current takes, over 0.4525 V s/rad.
    EXPECT_NEAR(motor.velocity_rad_s(), 713.0, 1.5);
    EXPECT_NEAR(motor.torque_nm(), 0.03 + 2e-4 * motor.velocity_rad_s(), 2e-3) << "friction is all that is left";
  }
}

TEST(ServoMotor, LessVoltageIsLessSpeed) {
  MotorParameters p;
  ServoMotor motor(p, kStep, 0.0);
  motor.set_dc_link_voltage(325.0);  // of 230 V mains
  for (int i = 0; i < 160'000; ++i) motor.step(7.2);
  EXPECT_NEAR(motor.velocity_rad_s(), 413.0, 2.0) << "187.6 V over 0.4525 V s/rad";
  motor.set_dc_link_voltage(162.5);
  motor.step(0.0);
  EXPECT_LT(motor.torque_range().highest_nm, 0.0) << "the back EMF drives current into the supply";
  for (int i = 0; i < 160'000; ++i) motor.step(7.2);
  EXPECT_NEAR(motor.velocity_rad_s(), 206.0, 2.0);
}

TEST(ServoMotor, NothingNotFiniteGetsIn) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  MotorParameters bad{nan, infinite, -1.0, 0.0, nan, -5.0, nan, nan, nan, 0};
  ServoMotor motor(bad, kStep, nan);
  for (const double torque : {nan, infinite, -infinite, 1e300, 0.1}) motor.step(torque);
  EXPECT_TRUE(std::isfinite(motor.position_rad()));
  EXPECT_TRUE(std::isfinite(motor.velocity_rad_s()));
  EXPECT_TRUE(std::isfinite(motor.torque_nm()));
  EXPECT_GE(motor.parameters().encoder_increments, 4U);
}

TEST(ServoMotor, EncoderCountsDownwardsRounded) {
  MotorParameters p;
  p.encoder_increments = 1000;
  const double increment = 2.0 * std::numbers::pi / 1000;
  EXPECT_EQ(ServoMotor(p, kStep, 10.5 * increment).encoder_count(), 10);
  EXPECT_EQ(ServoMotor(p, kStep, 0.5 * increment).encoder_count(), 0);
  EXPECT_EQ(ServoMotor(p, kStep, -0.5 * increment).encoder_count(), -1);
  EXPECT_EQ(ServoMotor(p, kStep, 5e4 * 2.0 * std::numbers::pi + 0.5 * increment).encoder_count(), 50'000'000);
}

}  // namespace
}  // namespace driveline::slaves
