#include "driveline/trajectory/coast.hpp"

#include <gtest/gtest.h>

namespace driveline::trajectory {
namespace {

constexpr double kCoastPeriod = 0.5;

TEST(Coast, GoesStraightOnAndThenSlowsDownToRest) {
  Coast coast(2, 4.0);
  coast.give(10.0, -3.0);
  for (const double position : {8.5, 7.0, 6.5, 6.5}) {
    EXPECT_DOUBLE_EQ(coast.next(kCoastPeriod).position, position) << "what comes is known before";
    coast.step(kCoastPeriod);
    EXPECT_DOUBLE_EQ(coast.position(), position);
  }
  EXPECT_EQ(coast.velocity(), 0.0);
}

TEST(Coast, BeginsAnewWithEverySetpointThatArrives) {
  Coast coast(1, 100.0);
  coast.give(0.0, 2.0);
  coast.step(kCoastPeriod);
  coast.give(1.0, 2.0);
  coast.step(kCoastPeriod);
  EXPECT_DOUBLE_EQ(coast.position(), 2.0);
  EXPECT_DOUBLE_EQ(coast.velocity(), 2.0);
}

TEST(Coast, ThatHoldsATorqueGoesOnAccelerating) {
  Coast coast(2, 4.0);
  coast.give(0.0, 1.0, 2.0);
  EXPECT_DOUBLE_EQ(coast.next(kCoastPeriod).velocity, 2.0);
  EXPECT_DOUBLE_EQ(coast.next(kCoastPeriod).acceleration, 2.0);
  for (const double velocity : {2.0, 3.0, 1.0}) {
    coast.step(kCoastPeriod);
    EXPECT_DOUBLE_EQ(coast.velocity(), velocity);
  }
  EXPECT_DOUBLE_EQ(coast.position(), 3.0);
  coast.give(0.0, 1.0);
  coast.step(kCoastPeriod);
  EXPECT_DOUBLE_EQ(coast.velocity(), 1.0) << "without a torque it holds its velocity";
}

TEST(Coast, WithoutDecelerationNeverSlowsDown) {
  Coast coast(1, 0.0);
  coast.give(0.0, 2.0);
  for (int i = 0; i < 100; ++i) coast.step(kCoastPeriod);
  EXPECT_DOUBLE_EQ(coast.position(), 100.0);
}

/// 10,000 periods are the longest gap that a line description allows.
TEST(Coast, SkipsPeriodsAsIfTheyHadPassedOneByOne) {
  constexpr double kShort = 125e-6;
  for (const double acceleration : {0.0, 300.0}) {
    for (const std::int64_t periods : {0, 1, 7, 8, 9, 60, 400, 10'000}) {
      Coast steps(8, 2000.0);
      steps.give(1.0, -37.0, acceleration);
      steps.step(kShort);
      auto skips = steps;
      for (std::int64_t i = 0; i < periods; ++i) steps.step(kShort);
      skips.skip(periods, kShort);
      EXPECT_NEAR(skips.position(), steps.position(), 1e-12) << periods;
      EXPECT_NEAR(skips.velocity(), steps.velocity(), 1e-9) << periods;
      EXPECT_NEAR(skips.next(kShort).position, steps.next(kShort).position, 1e-12) << periods;
    }
  }
}

TEST(Coast, WithoutDecelerationSkipsAtItsVelocity) {
  Coast coast(1, 0.0);
  coast.give(0.0, 2.0);
  coast.skip(100, kCoastPeriod);
  EXPECT_DOUBLE_EQ(coast.position(), 100.0);
  EXPECT_DOUBLE_EQ(coast.velocity(), 2.0);
}

}  // namespace
}  // namespace driveline::trajectory
