#include "driveline/motion/control/setpoint_supply.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace driveline::motion {
namespace {

using cia402::Mode;

constexpr double kSupplyPeriod = 125e-6;

AxisConfig supplied(Mode mode) {
  AxisConfig config;
  config.mode = mode;
  config.limits = {50.0, 1000.0};
  return config;
}

/// Setpoints at 10 rad/s, accelerating with 600 rad/s^2; it is unknown whether the last one has reached the drive, or
/// it has `certain`ly not.
SetpointSupply accelerating(Mode mode, bool certain = false) {
  auto config = supplied(mode);
  config.loss_is_certain = certain;
  SetpointSupply supply(config, kSupplyPeriod);
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

/// On CAN the drive cannot have a setpoint that the adapter refused. A step towards that one would leave a way to be
/// caught up with at top speed; here the drive sees the velocity that it has, however many setpoints are refused.
TEST(SetpointSupply, ADriveThatHasCertainlyNotGotTheLastOneIsMetExactlyWhereItGoes) {
  auto supply = accelerating(Mode::kCyclicPosition, true);
  const double velocity = 10.0 + 3 * 600.0 * kSupplyPeriod;
  for (int refused = 1; refused <= 4; ++refused) {
    EXPECT_NEAR(supply.sent_velocity(), velocity, 1e-9) << "refused: " << refused;
    const auto next = supply.bridge();
    EXPECT_NEAR(next.velocity, velocity, 1e-9) << "refused: " << refused;
    EXPECT_NEAR(next.position - supply.sent(), velocity * kSupplyPeriod, 1e-12) << "refused: " << refused;
    supply.set_reached(false);
    supply.note(next, Mode::kCyclicPosition);
  }
}

/// A drive bridges so many setpoints and no more, whether they were refused or the master was away.
TEST(SetpointSupply, CountsWhatTheDriveCertainlyLacks) {
  auto supply = accelerating(Mode::kCyclicPosition, true);
  EXPECT_EQ(supply.lacking(), 1);
  supply.skip(5, Mode::kCyclicPosition);
  EXPECT_EQ(supply.lacking(), 6);
  supply.set_reached(false);
  supply.note(supply.bridge(), Mode::kCyclicPosition);
  EXPECT_EQ(supply.lacking(), 7);
  supply.set_reached(true);
  supply.note(supply.bridge(), Mode::kCyclicPosition);
  EXPECT_EQ(supply.lacking(), 0);
}

/// On CAN it waited for the next SYNC, which has not come: the drive has gone on from the setpoint before.
TEST(SetpointSupply, TheLastSetpointBeforeMissedPeriodsHasNotTakenEffect) {
  auto config = supplied(Mode::kCyclicPosition);
  config.loss_is_certain = true;
  SetpointSupply supply(config, kSupplyPeriod);
  supply.start_from({0.0, 10.0, 0.0});
  double position = 0.0;
  for (const double velocity : {10.0, 9.9, 9.8}) {
    position += velocity * kSupplyPeriod;
    supply.note({position, velocity, 0.0}, Mode::kCyclicPosition);
  }
  const double before = position - 9.8 * kSupplyPeriod;
  supply.skip(3, Mode::kCyclicPosition);
  EXPECT_EQ(supply.lacking(), 4);
  EXPECT_NEAR(supply.sent(), before + 4 * 9.9 * kSupplyPeriod, 1e-12);
  EXPECT_NEAR(supply.bridge().velocity, 9.9, 1e-9);
}

/// An answer that is missing on EtherCAT says nothing about the setpoint.
TEST(SetpointSupply, CountsNothingThatTheDriveMayHave) {
  auto supply = accelerating(Mode::kCyclicPosition);
  supply.skip(5, Mode::kCyclicPosition);
  EXPECT_EQ(supply.lacking(), 0);
}

/// What was refused is not where the axis is: the way back begins where the drive has gone.
TEST(SetpointSupply, AfterARefusedSetpointTheAxisIsWhereItsDriveHasGone) {
  const auto lost = accelerating(Mode::kCyclicPosition, true);
  const auto unknown = accelerating(Mode::kCyclicPosition);
  EXPECT_NEAR(unknown.sent() - lost.sent(), 600.0 * kSupplyPeriod * kSupplyPeriod, 1e-12);
}

/// The drive holds the last velocity or the previous one: both are a step away, and braking would add another step.
TEST(SetpointSupply, ADriveThatHoldsItsVelocityIsToldTheSameAgain) {
  const auto supply = accelerating(Mode::kCyclicVelocity);
  EXPECT_DOUBLE_EQ(supply.bridge().velocity, supply.sent_velocity());
  EXPECT_DOUBLE_EQ(supply.bridge().acceleration, 0.0);
  EXPECT_FALSE(supply.by_torque());
}

/// It waits for another axis, whose drive slows down after eight periods as well.
TEST(SetpointSupply, AnAxisThatIsHeldUpIsBrakedAfterAsManyPeriodsAsOthersBridge) {
  for (const auto mode : {Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    SetpointSupply supply(supplied(mode), kSupplyPeriod);
    supply.start_from({0.0, 10.0, 0.0});
    double velocity = 10.0;
    for (std::uint32_t held_up = 1; held_up <= 100; ++held_up) {
      const auto next = supply.bridge(held_up);
      if (held_up > 8) velocity = std::max(velocity - 1000.0 * kSupplyPeriod, 0.0);
      ASSERT_NEAR(next.velocity, velocity, 1e-6) << "cycle " << held_up;
      ASSERT_NEAR(next.position - supply.sent(), velocity * kSupplyPeriod, 1e-9);
      supply.set_reached(true);
      supply.note(next, mode);
    }
    EXPECT_EQ(velocity, 0.0);
  }
}

/// Setpoints at 10 rad/s, accelerating with 600 rad/s^2, for a drive that is exchanged in every eighth cycle; the
/// answer to the last exchange is missing.
struct RareExchanges {
  static constexpr int kDivider = 8;
  static constexpr double kInterval = kDivider * kSupplyPeriod;

  explicit RareExchanges(double acceleration) : supply(supplied(Mode::kCyclicPosition), kSupplyPeriod, kDivider) {
    supply.start_from({0.0, 10.0, 0.0});
    double velocity = 10.0;
    for (int i = 0; i <= 3 * kDivider; ++i) {
      supply.set_reached(i < 3 * kDivider, i % kDivider == 0);
      velocity += acceleration * kSupplyPeriod;
      position += velocity * kSupplyPeriod;
      supply.note({position, velocity, acceleration}, Mode::kCyclicPosition);
      if (i % kDivider == 0) exchanged.push_back(position);
    }
  }
  /// Bridges until the next exchange and returns the setpoint that it carries.
  double next_exchange() {
    auto at = supply.bridge();
    for (int i = 1; i < kDivider; ++i) {
      supply.set_reached(false, false);
      supply.note(at, Mode::kCyclicPosition);
      at = supply.bridge();
    }
    supply.set_reached(false, true);
    supply.note(at, Mode::kCyclicPosition);
    return at.position;
  }

  SetpointSupply supply;
  double position = 0.0;
  std::vector<double> exchanged;  ///< positions carried by the exchanges, the lost one included
};

TEST(SetpointSupply, ADriveThatIsExchangedRarelyBridgesAsManyExchanges) {
  RareExchanges rare(0.0);
  for (int exchange = 1; exchange < 8; ++exchange) {
    const double expected = rare.position + 10.0 * RareExchanges::kInterval * exchange;
    EXPECT_NEAR(rare.next_exchange(), expected, 1e-9) << "exchange " << exchange;
  }
}

/// The drive may have the last setpoint or only the one before; from both it moves evenly on.
TEST(SetpointSupply, BetweenRareExchangesTheStepIsWithinTheLimitsWhicheverSetpointWasLost) {
  RareExchanges rare(600.0);
  const auto& sent = rare.exchanged;
  const double without_last = sent[2] + 2.0 * (sent[2] - sent[1]);
  const double with_last = sent[3] + (sent[3] - sent[2]);
  const double most = 1000.0 * RareExchanges::kInterval * RareExchanges::kInterval;
  const double next = rare.next_exchange();
  EXPECT_LE(std::abs(next - without_last), 1.001 * most);
  EXPECT_LE(std::abs(next - with_last), 1.001 * most);
}

/// The setpoints in between lead to that of the next exchange, the only one that the drive receives.
TEST(SetpointSupply, BetweenRareExchangesTheAxisMovesEvenly) {
  RareExchanges rare(600.0);
  const double velocity = rare.supply.bridge().velocity;
  for (int i = 1; i < RareExchanges::kDivider; ++i) {
    rare.supply.set_reached(false, false);
    rare.supply.note(rare.supply.bridge(), Mode::kCyclicPosition);
    ASSERT_NEAR(rare.supply.bridge().velocity, velocity, 1e-9) << "cycle " << i;
  }
}

/// A missed period between two exchanges costs the drive no setpoint.
TEST(SetpointSupply, MissedPeriodsBetweenRareExchangesLeaveTheDriveOnItsWay) {
  RareExchanges rare(0.0);
  rare.supply.skip(3, Mode::kCyclicPosition);
  const auto next = rare.supply.bridge();
  EXPECT_NEAR(rare.supply.sent(), rare.position + 3 * 10.0 * kSupplyPeriod, 1e-9);
  EXPECT_NEAR(next.velocity, 10.0, 1e-6);
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
}  // namespace driveline::motion
