#include "driveline/slaves/plant/mechanics.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "driveline/slaves/plant/current_loop.hpp"
#include "driveline/slaves/plant/servo_controller.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves {
namespace {

constexpr double kStep = 62.5e-6;
constexpr RotorParameters kFree{.inertia_kg_m2 = 3e-4, .viscous_friction_nm_s = 0.0, .coulomb_friction_nm = 0.0};

TEST(Mechanics, TwoMassesSwingWithTheirNaturalFrequencyAndKeepTheirEnergy) {
  LoadParameters load;
  load.inertia_kg_m2 = 6e-4;
  load.stiffness_nm_rad = 200.0;
  load.damping_nm_s = 0.0;
  Mechanics mechanics(kFree, load, kStep, 0.0);
  for (int i = 0; i < 40; ++i) mechanics.step(3.0, false);
  const double energy = mechanics.energy_j();
  const double mean =
      (3e-4 * mechanics.velocity_rad_s() + 6e-4 * mechanics.load_velocity_rad_s()) / 9e-4;  // of the centre of mass
  int crossings = 0;
  bool above = mechanics.velocity_rad_s() > mean;
  constexpr int kSteps = 160'000;  // 10 s
  for (int i = 0; i < kSteps; ++i) {
    mechanics.step(0.0, false);
    ASSERT_NEAR(mechanics.energy_j(), energy, 1e-9 * energy + 1e-12 * i);
    const bool now = mechanics.velocity_rad_s() > mean;
    crossings += now != above ? 1 : 0;
    above = now;
  }
  const double expected = std::sqrt(200.0 * (1 / 3e-4 + 1 / 6e-4)) / (2.0 * std::numbers::pi);  // 159 Hz
  EXPECT_NEAR(crossings / 2.0 / (kSteps * kStep), expected, 0.01 * expected);
}

TEST(Mechanics, StiffCouplingIsTheRigidAxis) {
  LoadParameters load;
  load.inertia_kg_m2 = 6e-4;
  load.stiffness_nm_rad = 1e6;
  load.damping_nm_s = 1.0;
  Mechanics elastic(kFree, load, kStep, 0.0);
  RotorParameters together = kFree;
  together.inertia_kg_m2 = 9e-4;
  Mechanics rigid(together, {}, kStep, 0.0);
  for (int i = 0; i < 16'000; ++i) {
    const double torque = std::sin(1e-3 * i);
    elastic.step(torque, false);
    rigid.step(torque, false);
  }
  EXPECT_NEAR(elastic.position_rad(), rigid.position_rad(), 1e-3 * std::abs(rigid.position_rad()));
  EXPECT_NEAR(elastic.load_velocity_rad_s(), rigid.velocity_rad_s(), 1.0);
}

TEST(Mechanics, EnergyNeverGrowsWithoutTorque) {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> exponent(-6.0, 0.0);
  const auto value = [&] { return std::pow(10.0, exponent(random)); };
  for (int run = 0; run < 300; ++run) {
    RotorParameters rotor = kFree;
    rotor.inertia_kg_m2 = value();
    rotor.viscous_friction_nm_s = run % 2 == 0 ? 0.0 : value();
    rotor.coulomb_friction_nm = run % 3 == 0 ? 0.0 : value();
    LoadParameters load;
    load.inertia_kg_m2 = run % 5 == 0 ? 0.0 : value();
    load.stiffness_nm_rad = 1e6 * value();
    load.damping_nm_s = value();
    load.coulomb_friction_nm = run % 3 == 1 ? 0.0 : value();
    load.end_stop_min_rad = -0.5;
    load.end_stop_max_rad = 0.5;
    load.end_stop_stiffness_nm_rad = 1e5 * value();
    load.end_stop_damping_nm_s = value();
    Mechanics mechanics(rotor, load, kStep, 0.0);
    for (int i = 0; i < 200; ++i) mechanics.step(run % 4 == 0 ? 5.0 : -1.0, false);
    double energy = mechanics.energy_j();
    const double most = energy;
    for (int i = 0; i < 2000; ++i) {
      mechanics.step(0.0, false);
      if (std::abs(mechanics.load_position_rad()) > 0.5)
        continue;  // forces that a hard stop holds for a moment do not count
      ASSERT_LE(mechanics.energy_j(), energy + 1e-12 * most) << run << ' ' << i;
      energy = mechanics.energy_j();
    }
  }
}

TEST(Mechanics, WeightFallsAndTheBrakeHoldsIt) {
  LoadParameters load;
  load.gravity_nm = 0.5;
  RotorParameters rotor = kFree;
  rotor.brake_torque_nm = 2.0;
  Mechanics mechanics(rotor, load, kStep, 0.0);
  for (int i = 0; i < 1600; ++i) mechanics.step(0.0, true);
  EXPECT_EQ(mechanics.position_rad(), 0.0);
  for (int i = 0; i < 1600; ++i) mechanics.step(0.0, false);  // 0.1 s
  EXPECT_NEAR(mechanics.velocity_rad_s(), -0.5 / 3e-4 * 0.1, 1e-6);
  EXPECT_NEAR(mechanics.energy_j(), 0.0, 1e-9) << "what the weight loses the rotor gains";
  for (int i = 0; i < 1600; ++i) mechanics.step(0.0, true);
  EXPECT_EQ(mechanics.velocity_rad_s(), 0.0);
}

TEST(Mechanics, MassesStickWithinTheirFriction) {
  RotorParameters rotor = kFree;
  rotor.coulomb_friction_nm = 0.05;
  LoadParameters load;
  load.inertia_kg_m2 = 6e-4;
  load.coulomb_friction_nm = 0.2;
  Mechanics mechanics(rotor, load, kStep, 0.0);
  for (int i = 0; i < 16'000; ++i) mechanics.step(0.049, false);
  EXPECT_EQ(mechanics.position_rad(), 0.0);
  for (int i = 0; i < 64'000; ++i) mechanics.step(0.14, false);  // twists the coupling; the load holds
  EXPECT_GT(mechanics.position_rad(), 0.5 * 0.09 / load.stiffness_nm_rad);
  EXPECT_EQ(mechanics.load_position_rad(), 0.0);
  for (int i = 0; i < 16'000; ++i) mechanics.step(0.3, false);
  EXPECT_GT(mechanics.load_position_rad(), 1.0);
}

TEST(Mechanics, EndStopsHoldAgainstTheTorqueAndLetGo) {
  LoadParameters load;
  load.end_stop_min_rad = -1.0;
  load.end_stop_max_rad = 1.0;
  load.end_stop_stiffness_nm_rad = 1000.0;
  Mechanics mechanics(kFree, load, kStep, 0.0);
  for (int i = 0; i < 32'000; ++i) mechanics.step(2.0, false);
  EXPECT_NEAR(mechanics.position_rad(), 1.0 + 2.0 / 1000.0, 1e-5) << "torque over stiffness";
  EXPECT_NEAR(mechanics.velocity_rad_s(), 0.0, 1e-3);
  for (int i = 0; i < 200; ++i) mechanics.step(-2.0, false);
  EXPECT_LT(mechanics.position_rad(), 0.9) << "a stop does not hold back";
  for (int i = 0; i < 32'000; ++i) mechanics.step(-2.0, false);
  EXPECT_NEAR(mechanics.position_rad(), -1.002, 1e-5);
}

TEST(Mechanics, NothingNotFiniteGetsIn) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const LoadParameters bad{nan, nan, -1.0, nan, nan, nan, nan, nan, nan};
  Mechanics mechanics(kFree, bad, kStep, 0.0);
  for (int i = 0; i < 100; ++i) mechanics.step(1.0, false);
  EXPECT_TRUE(std::isfinite(mechanics.position_rad()));
}

CurrentLoop small_motor(double saturation_a = 0.0) {
  return {{.simulated = true, .resistance_ohm = 1.2, .inductance_h = 4e-3, .saturation_current_a = saturation_a},
          0.414,
          4,
          1.5e-4,
          kStep};
}

TEST(CurrentLoop, FollowsItsSetpointInTheTimeOfItsLag) {
  CurrentLoop loop = small_motor();
  double torque = 0.0;
  for (int i = 0; i < 3; ++i) torque = loop.step(1.0, 0.0, 560.0);
  EXPECT_GT(torque, 0.4);
  EXPECT_LT(torque, 0.9);
  for (int i = 0; i < 160; ++i) torque = loop.step(1.0, 0.0, 560.0);
  EXPECT_NEAR(torque, 1.0, 1e-3);
  EXPECT_NEAR(loop.q_current_a(), 1.0 / 0.414, 1e-2);
  EXPECT_NEAR(loop.d_current_a(), 0.0, 1e-6);
  EXPECT_NEAR(loop.loss_w(), 1.5 * 1.2 * std::pow(1.0 / 0.414, 2), 0.1);
}

TEST(CurrentLoop, BackEmfLimitsTheTorqueAtHighSpeed) {
  // Flux 0.069 Vs, 4 pole pairs, 628 rad/s: 173 V of back EMF.
  for (const double volts : {560.0, 250.0}) {
    CurrentLoop loop = small_motor();
    double torque = 0.0;
    for (int i = 0; i < 1600; ++i) torque = loop.step(3.0, 628.0, volts);
    EXPECT_EQ(loop.limited(), volts < 300.0);
    if (volts < 300.0) {
      EXPECT_LT(torque, 0.5) << "144 V are less than the back EMF";
    } else {
      EXPECT_NEAR(torque, 3.0, 0.05);
    }
  }
}

TEST(CurrentLoop, LimitDoesNotWindUp) {
  CurrentLoop loop = small_motor();
  for (int i = 0; i < 16'000; ++i) loop.step(7.0, 628.0, 100.0);
  double torque = 0.0;
  for (int i = 0; i < 160; ++i) torque = loop.step(1.0, 0.0, 560.0);
  EXPECT_NEAR(torque, 1.0, 0.02);
}

TEST(CurrentLoop, SaturationTakesTorqueAtHighCurrents) {
  CurrentLoop loop = small_motor(10.0);
  double torque = 0.0;
  for (int i = 0; i < 800; ++i) torque = loop.step(4.14, 0.0, 560.0);
  EXPECT_NEAR(torque, 4.14 / std::numbers::sqrt2, 0.02);
}

TEST(CurrentLoop, StaysFiniteAtEverySpeed) {
  CurrentLoop loop = small_motor();
  for (const double speed : {1e5, -1e5, std::numeric_limits<double>::infinity()}) {
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(std::isfinite(loop.step(5.0, speed, 560.0)));
    ASSERT_LT(std::abs(loop.q_current_a()), 1e4);
  }
}

TEST(ServoMotorWinding, CascadeHoldsThePositionOfATwoMassAxisWithAWeight) {
  MotorParameters p;
  p.winding.simulated = true;
  p.load.inertia_kg_m2 = 2e-4;
  p.load.stiffness_nm_rad = 2000.0;
  p.load.damping_nm_s = 0.02;
  p.load.gravity_nm = 0.8;
  ServoMotor motor(p, kStep, 0.0);
  ServoController controller({}, kStep);
  for (int i = 0; i < 16'000; ++i) {
    controller.measure(static_cast<double>(motor.encoder_count()) * motor.radians_per_increment());
    motor.step(controller.step({ControllerSetpoint::Loop::kPosition, 0.5, 0.0, 0.0}));
  }
  EXPECT_NEAR(motor.position_rad(), 0.5, 1e-3);
  EXPECT_NEAR(motor.torque_nm(), 0.8, 0.05);
  EXPECT_NEAR(motor.mechanics().load_position_rad(), 0.5 - 0.8 / 2000.0, 1e-3);
}

TEST(ServoMotorEncoder, NoiseRepeatsWithItsSeedAndStaysWithinItsBounds) {
  const auto run = [](std::uint32_t seed) {
    MotorParameters p;
    p.encoder_noise_increments = 5.0;
    p.encoder_seed = seed;
    ServoMotor motor(p, kStep, 1.0);
    std::vector<std::int64_t> counts;
    for (int i = 0; i < 2000; ++i) {
      motor.step(0.0);
      counts.push_back(motor.encoder_count() - motor.encoder_count(motor.position_rad()));
    }
    return counts;
  };
  const auto counts = run(7);
  EXPECT_EQ(counts, run(7));
  EXPECT_NE(counts, run(8));
  EXPECT_THAT(counts, testing::Each(testing::AllOf(testing::Ge(-5), testing::Le(5))));
  EXPECT_THAT(counts, testing::Contains(5));
  EXPECT_THAT(counts, testing::Contains(-5));
}

TEST(ServoMotorEncoder, PowerOnOriginDependsOnTheTurnsItKnows) {
  MotorParameters p;
  p.encoder_increments = 1000;
  const double position = -2.25 * 2.0 * std::numbers::pi;
  const auto origin = [&](std::uint32_t turns) {
    p.encoder_turns = turns;
    const ServoMotor motor(p, kStep, position);
    return motor.encoder_count() - motor.power_on_origin();
  };
  EXPECT_EQ(origin(0), 0) << "incremental";
  EXPECT_NEAR(static_cast<double>(origin(1)), 750.0, 1.0) << "single-turn";
  EXPECT_NEAR(static_cast<double>(origin(4)), 1750.0, 1.0) << "four turns";
  EXPECT_NEAR(static_cast<double>(origin(MotorParameters::kAllTurns)), -2250.0, 1.0);
}

}  // namespace
}  // namespace driveline::slaves
