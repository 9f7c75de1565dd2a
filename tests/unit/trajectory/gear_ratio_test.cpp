#include "driveline/trajectory/gear_ratio.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::int64_t kGigaIncrements = 1'000'000'000;

TEST(GearRatio, IsReducedAndCarriesItsSignAbove) {
  const auto ratio = GearRatio::make(-6, -4).value();
  EXPECT_EQ(ratio.numerator(), 3);
  EXPECT_EQ(ratio.denominator(), 2);
  const auto reversed = GearRatio::make(10, -4).value();
  EXPECT_EQ(reversed.numerator(), -5);
  EXPECT_EQ(reversed.denominator(), 2);
  EXPECT_EQ(reversed.factor(), -2.5);
  EXPECT_EQ(GearRatio().factor(), 1.0);
}

TEST(GearRatio, RefusesWhatIsNoRatio) {
  EXPECT_EQ(GearRatio::make(0, 3).error().message(),
            "a gear ratio of 0 : 3 is not possible: both numbers must be other than 0");
  EXPECT_EQ(GearRatio::make(1, 0).error().message(),
            "a gear ratio of 1 : 0 is not possible: both numbers must be other than 0");
  EXPECT_EQ(GearRatio::make(kMaxGearNumber + 1, 1).error().message(),
            "a gear ratio of 2147483649 : 1 is not possible: both numbers must be within +-2147483648");
  EXPECT_EQ(GearRatio::make(1, INT64_MIN).error().message(),
            "a gear ratio of 1 : -9223372036854775808 is not possible: both numbers must be within +-2147483648");
  EXPECT_TRUE(GearRatio::make(-kMaxGearNumber, kMaxGearNumber).has_value());
}

TEST(GearRatio, OfTwoDistancesHasAnyUnits) {
  constexpr double kTurn = 6.283185307179586;
  const auto screw = GearRatio::of_travel(0.01, kTurn).value();
  EXPECT_DOUBLE_EQ(screw.travel(1000.0 * kTurn), 10.0);
  EXPECT_DOUBLE_EQ(screw.factor(), 0.01 / kTurn);
  const auto back = GearRatio::of_travel(kTurn, -0.025).value();
  EXPECT_DOUBLE_EQ(back.travel(0.4), -16.0 * kTurn);
  EXPECT_DOUBLE_EQ(back.factor(), -40.0 * kTurn);
  for (const double wrong : {0.0, std::nan(""), HUGE_VAL, 1e-30, 1e30}) {
    EXPECT_FALSE(GearRatio::of_travel(wrong, 3.0)) << wrong;
    EXPECT_FALSE(GearRatio::of_travel(3.0, wrong)) << wrong;
  }
}

// 355 : 113 of 10^9 increments is 3141592920 and 40 / 113: 113 * 3141592920 + 40 = 355 * 10^9.
TEST(GearRatio, IsExactAfterAThousandMillionIncrements) {
  const auto ratio = GearRatio::make(355, 113).value();
  EXPECT_EQ(ratio.travel(kGigaIncrements), (GearRatio::Increments{3141592920, 40}));
  EXPECT_EQ(ratio.travel(-kGigaIncrements), (GearRatio::Increments{-3141592921, 73}));
  const double exact = 3141592920.0 + 40.0 / 113.0;
  EXPECT_NEAR(ratio.travel(static_cast<double>(kGigaIncrements)), exact, 3e-16 * exact);
}

// Adding up the value of each increment would be off by many increments by then.
TEST(GearRatio, DoesNotDriftWhereAddingUpWould) {
  const auto ratio = GearRatio::make(1, 3).value();
  double added = 0.0;
  const double step = ratio.travel(0.1);
  for (int i = 0; i < 3'000'000; ++i) added += step;
  EXPECT_GT(std::abs(added - 1e5), 1e-7);
  EXPECT_NEAR(ratio.travel(3e5), 1e5, 1e-10);
}

TEST(GearRatio, EveryIncrementIsTheProductRoundedDown) {
  test::Random random;
  for (int round = 0; round < 20000; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const auto numerator = static_cast<std::int64_t>(random.real(1.0, 3e4)) * (round % 2 == 0 ? 1 : -1);
    const auto denominator = static_cast<std::int64_t>(random.real(1.0, 3e4));
    const auto ratio = GearRatio::make(numerator, denominator).value();
    const auto master = static_cast<std::int64_t>(random.real(-1e12, 1e12));
    const auto [whole, remainder] = ratio.travel(master);
    ASSERT_GE(remainder, 0);
    ASSERT_LT(remainder, ratio.denominator());
    ASSERT_EQ(whole * ratio.denominator() + remainder, master * ratio.numerator());
  }
}

}  // namespace
}  // namespace driveline::trajectory
