#include "driveline/ecat_master/cyclic/setpoint_supply.hpp"

#include <gtest/gtest.h>

namespace driveline::ecat_master {
namespace {

using cia402::Mode;

constexpr double kSupplyPeriod = 125e-6;

AxisConfig supplied(Mode mode) {
  AxisConfig config;
  config.mode = mode;
  config.limits = {50.0, 1000.0};
  return config;
}

/// Setpoints at 10 rad/s, accelerating with 600 rad/s^2; it is unknown whether the last one has reached the drive.
SetpointSupply accelerating(Mode mode) {
  SetpointSupply supply(supplied(mode), kSupplyPeriod);
  double position = 0.0;
  double velocity = 10.0;
  for (int i = 0; i < 4; ++i) {
    supply.set_reached(i < 3);
    velocity += 600.0 * kSupplyPeriod;
    position += velocity * kSupplyPeriod;
    supply.note({position, velocity, 600.0}, mode);
  }
  return supply;
}

TEST(SetpointSupply, ADriveThatFollowsPositionsIsMetWhereItGoesWithoutTheLastOne) {
  const auto supply = accelerating(Mode::kCyclicPosition);
  const auto next = supply.bridge();
  EXPECT_LT(next.velocity, supply.sent_velocity());
  EXPECT_GE(next.velocity, supply.sent_velocity() - 1000.0 * kSupplyPeriod);
}

/// The drive holds the last velocity or the previous one: both are a step away, and braking would add another step.
TEST(SetpointSupply, ADriveThatHoldsItsVelocityIsToldTheSameAgain) {
  const auto supply = accelerating(Mode::kCyclicVelocity);
  EXPECT_DOUBLE_EQ(supply.bridge().velocity, supply.sent_velocity());
  EXPECT_DOUBLE_EQ(supply.bridge().acceleration, 0.0);
  EXPECT_FALSE(supply.by_torque());
}

/// A coasting axis that gets its position after missed periods.
TEST(SetpointSupply, ADriveThatHoldsItsVelocityGoesOnWithItHoweverFarTheLastStepWas) {
  SetpointSupply supply(supplied(Mode::kCyclicVelocity), kSupplyPeriod);
  supply.note({1.0, -0.5, 0.0}, Mode::kCyclicVelocity);
  supply.note({1.0 - 4 * 0.5 * kSupplyPeriod, -0.5, 0.0}, Mode::kCyclicVelocity);
  EXPECT_DOUBLE_EQ(supply.sent_velocity(), -0.5);
  supply.skip(3, Mode::kCyclicVelocity);
  EXPECT_NEAR(supply.sent(), 1.0 - 7 * 0.5 * kSupplyPeriod, 1e-12);
  EXPECT_DOUBLE_EQ(supply.bridge().velocity, -0.5);
}

TEST(SetpointSupply, ADriveThatHoldsItsTorqueIsExpectedToGoOnAccelerating) {
  auto supply = accelerating(Mode::kCyclicTorque);
  EXPECT_TRUE(supply.by_torque());
  EXPECT_NEAR(supply.bridge().velocity, supply.sent_velocity() + 600.0 * kSupplyPeriod, 1e-9);
  EXPECT_NEAR(supply.bridge().acceleration, 600.0, 1e-6);
  const double before = supply.sent_velocity();
  supply.skip(4, Mode::kCyclicTorque);
  EXPECT_NEAR(supply.sent_velocity(), before + 4 * 600.0 * kSupplyPeriod, 1e-9);
}

/// When a torque leads an axis, its setpoints tell nothing.
TEST(SetpointSupply, AnAxisGoesOnFromWhereItIsThoughTheLastSetpointMayNotHaveReachedIt) {
  auto supply = accelerating(Mode::kCyclicTorque);
  supply.set_reached(false);
  supply.start_from({-2.0, -18.0, 0.0});
  EXPECT_EQ(supply.sent(), -2.0);
  EXPECT_EQ(supply.sent_velocity(), -18.0);
  supply.skip(4, Mode::kCyclicTorque);
  EXPECT_NEAR(supply.sent(), -2.0 - 4 * 18.0 * kSupplyPeriod, 1e-12);
  EXPECT_NEAR(supply.bridge().velocity, -18.0, 1e-9);
}

/// The drive need not have received the last command.
TEST(SetpointSupply, GoesOnThroughAGapByTheModeThatTheDriveIsIn) {
  auto supply = accelerating(Mode::kCyclicTorque);
  const double before = supply.sent_velocity();
  supply.skip(4, Mode::kCyclicVelocity);
  EXPECT_NEAR(supply.sent_velocity(), before, 1e-9);
}

TEST(SetpointSupply, AHeldTorqueTakesNoSetpointBeyondTheHighestVelocity) {
  SetpointSupply supply(supplied(Mode::kCyclicTorque), kSupplyPeriod);
  supply.note({0.0, 49.99, 1000.0}, Mode::kCyclicTorque);
  supply.note({49.99 * kSupplyPeriod, 49.99, 1000.0}, Mode::kCyclicTorque);
  const auto next = supply.bridge();
  EXPECT_DOUBLE_EQ(next.velocity, 50.0);
  EXPECT_NEAR(next.acceleration, 0.01 / kSupplyPeriod, 1e-6) << "the torque of it, too";
}

TEST(SetpointSupply, FollowsTheModeOfItsDrive) {
  auto supply = accelerating(Mode::kCyclicPosition);
  supply.set_reached(true);
  supply.note({supply.sent() + 1e-3, 8.0, 600.0}, Mode::kCyclicTorque);
  EXPECT_TRUE(supply.by_torque());
  EXPECT_NEAR(supply.bridge().acceleration, 600.0, 1e-6);
}

}  // namespace
}  // namespace driveline::ecat_master
