#include "driveline/motion/axis/feed_forward.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace driveline::motion {
namespace {

TEST(FeedForward, OfAnAxisWithoutAnythingIsNone) {
  const FeedForward none;
  EXPECT_FALSE(none.any());
  EXPECT_EQ(none.torque({1.0, 20.0, 300.0}), 0.0);
}

TEST(FeedForward, AnyOfItsPartsIsAFeedForward) {
  EXPECT_TRUE(FeedForward{.viscous_friction = 1e-6}.any());
  EXPECT_TRUE(FeedForward{.coulomb_friction = 1e-6}.any());
  EXPECT_TRUE(FeedForward{.gravity = -1e-6}.any());
  EXPECT_TRUE(FeedForward{.gravity = 1e-6}.any());
  EXPECT_TRUE(FeedForward{.pendulum = 1e-6}.any());
  EXPECT_FALSE(FeedForward{.pendulum_zero = 1.0}.any());
}

TEST(FeedForward, FrictionIsAgainstTheMotion) {
  const FeedForward load{.viscous_friction = 0.01, .coulomb_friction = 0.5, .coulomb_velocity = 0.2};
  EXPECT_DOUBLE_EQ(load.torque({0.0, 10.0, 0.0}), 0.6);
  EXPECT_DOUBLE_EQ(load.torque({0.0, -10.0, 0.0}), -0.6);
}

TEST(FeedForward, DryFrictionHasNoStepWhereTheAxisTurnsRound) {
  const FeedForward load{.coulomb_friction = 0.5, .coulomb_velocity = 0.2};
  EXPECT_EQ(load.torque({0.0, 0.0, 100.0}), 0.0) << "at standstill none";
  EXPECT_DOUBLE_EQ(load.torque({0.0, 0.1, 0.0}), 0.25);
  EXPECT_DOUBLE_EQ(load.torque({0.0, -0.1, 0.0}), -0.25);
  EXPECT_DOUBLE_EQ(load.torque({0.0, 0.2, 0.0}), 0.5);
  EXPECT_DOUBLE_EQ(load.torque({0.0, 200.0, 0.0}), 0.5);
}

TEST(FeedForward, AWeightIsHeldAtStandstill) {
  EXPECT_DOUBLE_EQ(FeedForward{.gravity = -1.5}.torque({7.0, 0.0, 0.0}), -1.5);
  const FeedForward pendulum{.pendulum = 2.0, .pendulum_zero = 1.0};
  EXPECT_NEAR(pendulum.torque({1.0, 0.0, 0.0}), 0.0, 1e-15) << "it hangs down";
  EXPECT_NEAR(pendulum.torque({1.0 + std::numbers::pi / 2.0, 0.0, 0.0}), 2.0, 1e-15);
  EXPECT_NEAR(pendulum.torque({1.0 - std::numbers::pi / 6.0, 0.0, 0.0}), -1.0, 1e-15);
}

}  // namespace
}  // namespace driveline::motion
