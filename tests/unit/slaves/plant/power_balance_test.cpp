// Power balance: the inverter's power becomes heat in the windings, friction, motion, a lifted weight.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves {
namespace {

constexpr double kStepS = 62.5e-6;

/// Work and losses of a run, added up step by step.
struct Account {
  double electrical_j = 0.0;  ///< put into the windings
  double copper_j = 0.0;
  double shaft_j = 0.0;  ///< work of the torque
  double friction_j = 0.0;
  double stored_j = 0.0;  ///< change of kinetic, elastic and potential energy
  double field_j = 0.0;   ///< change of the energy in the windings
};

MotorParameters machine() {
  MotorParameters p;
  p.winding.simulated = true;
  p.coulomb_friction_nm = 0.05;
  p.viscous_friction_nm_s = 1e-3;
  return p;
}

/// Two seconds of torque that lifts, brakes and lowers.
Account run(const MotorParameters& parameters) {
  ServoMotor motor(parameters, kStepS, 0.0);
  const auto stored = [&motor] { return motor.mechanics().energy_j(); };
  const double before = stored();
  Account account;
  double rotor = 0.0;
  double load = 0.0;
  for (int i = 0; i < 32'000; ++i) {
    const double t = i * kStepS;
    motor.step(parameters.load.gravity_nm + 1.2 * std::sin(2.0 * 3.141592653589793 * 1.5 * t));
    const double rotor_now = motor.velocity_rad_s();
    const double load_now = motor.mechanics().load_velocity_rad_s();
    const double speed = 0.5 * (rotor + rotor_now);
    const double load_speed = 0.5 * (load + load_now);
    const bool elastic = parameters.load.inertia_kg_m2 > 0.0;
    account.electrical_j += motor.current_loop().power_w() * kStepS;
    account.copper_j += motor.current_loop().loss_w() * kStepS;
    account.shaft_j += motor.torque_nm() * speed * kStepS;
    account.friction_j +=
        (parameters.coulomb_friction_nm * std::abs(speed) + parameters.viscous_friction_nm_s * speed * speed +
         parameters.load.coulomb_friction_nm * std::abs(elastic ? load_speed : speed)) *
        kStepS;
    if (elastic) account.friction_j += parameters.load.damping_nm_s * std::pow(speed - load_speed, 2.0) * kStepS;
    rotor = rotor_now;
    load = load_now;
  }
  account.stored_j = stored() - before;
  account.field_j = motor.current_loop().energy_j();
  return account;
}

void expect_balanced(const Account& account) {
  EXPECT_GT(account.electrical_j, 1.0) << "there is something to balance";
  EXPECT_GT(account.copper_j, 0.1);
  EXPECT_GT(account.friction_j, 0.1);
  EXPECT_NEAR(account.electrical_j, account.copper_j + account.shaft_j + account.field_j, 0.02 * account.electrical_j);
  const double moved = std::abs(account.shaft_j) + std::abs(account.stored_j);
  EXPECT_NEAR(account.shaft_j, account.stored_j + account.friction_j, 0.02 * moved);
}

TEST(PowerBalance, RigidAxisWithFriction) {
  expect_balanced(run(machine()));
}

TEST(PowerBalance, WeightIsLiftedAndLetDown) {
  auto parameters = machine();
  parameters.load.gravity_nm = 0.8;
  parameters.load.coulomb_friction_nm = 0.1;
  expect_balanced(run(parameters));
}

/// Accelerates with full torque, holds the speed, brakes: at every speed in either direction the energy from the DC
/// link becomes heat, friction and motion, to one percent of the exchanged energy.
TEST(PowerBalance, HoldsOverTheWholeSpeedRange) {
  for (const bool windings : {false, true}) {
    for (const double speed : {50.0, 150.0, 300.0, 450.0, 550.0, 620.0, 200.0 * std::numbers::pi, 700.0, 5000.0}) {
      for (const double target : {speed, -speed}) {
        auto parameters = machine();
        parameters.winding.simulated = windings;
        ServoMotor motor(parameters, kStepS, 0.0);
        double electrical_j = 0.0;
        double spent_j = 0.0;  // copper and friction
        double moved_j = 0.0;
        double last = 0.0;
        const auto run = [&](double wanted, double time_s) {
          for (int i = 0; i < static_cast<int>(time_s / kStepS); ++i) {
            motor.step(2.0 * (wanted - motor.velocity_rad_s()));
            const double now = motor.velocity_rad_s();
            const double mean = 0.5 * (last + now);
            last = now;
            const double current = motor.current_a();
            electrical_j += motor.power_w() * kStepS;
            moved_j += std::abs(motor.power_w()) * kStepS;
            spent_j +=
                (1.5 * parameters.winding.resistance_ohm * current * current +
                 parameters.coulomb_friction_nm * std::abs(mean) + parameters.viscous_friction_nm_s * mean * mean) *
                kStepS;
          }
          return std::pair(electrical_j - spent_j, motor.mechanics().energy_j());
        };
        for (const double wanted : {target, 0.0}) {
          const auto [left, stored] = run(wanted, 2.0);
          EXPECT_NEAR(left, stored, 0.01 * moved_j) << target << " rad/s, windings " << windings << ", to " << wanted;
          if (wanted != 0.0 && std::abs(wanted) < 700.0) {
            EXPECT_NEAR(motor.velocity_rad_s(), wanted, 0.01 * speed) << "it gets there";
          }
        }
      }
    }
  }
}

/// With the power stage off no energy enters or leaves the windings: the shaft loses energy only by friction.
TEST(PowerBalance, PowerStageOffLeavesFrictionAlone) {
  const auto parameters = machine();
  for (const double dc_link_volts : {560.0, 0.0}) {
    ServoMotor motor(parameters, kStepS, 0.0);
    for (int i = 0; i < 1600; ++i) motor.step(1.2);
    ASSERT_GT(motor.velocity_rad_s(), 300.0);
    motor.set_dc_link_voltage(dc_link_volts);
    motor.set_power_stage(false);
    const double before = motor.kinetic_energy_j();
    double friction_j = 0.0;
    double last = motor.velocity_rad_s();
    for (int i = 0; i < 1600; ++i) {
      motor.step(1.2);
      const double speed = 0.5 * (last + motor.velocity_rad_s());
      last = motor.velocity_rad_s();
      friction_j +=
          (parameters.coulomb_friction_nm * speed + parameters.viscous_friction_nm_s * speed * speed) * kStepS;
      EXPECT_EQ(motor.torque_nm(), 0.0);
      EXPECT_EQ(motor.current_loop().power_w(), 0.0);
    }
    EXPECT_GT(friction_j, 1.0);
    EXPECT_NEAR(before - motor.kinetic_energy_j(), friction_j, 0.01 * friction_j);
  }
}

/// Without a voltage to switch no current flows, also in the step in which the voltage is lost.
TEST(PowerBalance, NoDcLinkIsNoShortCircuit) {
  ServoMotor motor(machine(), kStepS, 0.0);
  for (int i = 0; i < 1600; ++i) motor.step(1.2);
  motor.set_dc_link_voltage(0.0);
  motor.step(1.2);
  EXPECT_EQ(motor.torque_nm(), 0.0);
}

TEST(PowerBalance, TwoMassesWithAWeight) {
  auto parameters = machine();
  parameters.load.gravity_nm = 0.5;
  parameters.load.inertia_kg_m2 = 2e-4;
  parameters.load.stiffness_nm_rad = 300.0;
  parameters.load.damping_nm_s = 0.02;
  parameters.load.coulomb_friction_nm = 0.05;
  expect_balanced(run(parameters));
}

}  // namespace
}  // namespace driveline::slaves
