// Modes 0 to 2 of limit switches and software limits, and the axis that they stop.
#include "driveline/slaves/position_servo/travel_limits.hpp"

#include <gtest/gtest.h>

#include <string>

#include "driveline/slaves/position_servo/motion.hpp"

namespace driveline::slaves::position_servo::travel_limits_test {
namespace {

using Reaction = TravelLimits::Reaction;

struct Row {
  std::string name;
  LimitMode software;
  LimitMode switches;
  LimitInputs inputs;
  Reaction reaction;
};

constexpr LimitInputs at(std::int64_t position, int direction, bool negative = false, bool positive = false) {
  return {.negative_switch = negative, .positive_switch = positive, .position = position, .direction = direction};
}

class TravelLimitsMode : public testing::TestWithParam<Row> {};

/// Software limits at -250 and 400. Each row begins inside of all limits.
TEST_P(TravelLimitsMode, HasItsReactionOnce) {
  const Row& row = GetParam();
  TravelLimits limits;
  limits.configure({.software = row.software, .negative = -250, .positive = 400, .switches = row.switches});
  EXPECT_EQ(limits.step(at(7, row.inputs.direction)), Reaction::kNone);
  EXPECT_EQ(limits.step(row.inputs), row.reaction);
  EXPECT_EQ(limits.negative_switch(), row.inputs.negative_switch);
  EXPECT_EQ(limits.positive_switch(), row.inputs.positive_switch);
  EXPECT_EQ(limits.step(row.inputs), Reaction::kNone);
  EXPECT_EQ(limits.step(at(7, row.inputs.direction)), Reaction::kNone);
  EXPECT_FALSE(limits.negative_switch() || limits.positive_switch());
  EXPECT_EQ(limits.step(row.inputs), row.reaction) << "left and hit again";
}

constexpr LimitMode kOff = LimitMode::kOff;
constexpr LimitMode kDisable = LimitMode::kDisable;
constexpr LimitMode kStop = LimitMode::kStop;

INSTANTIATE_TEST_SUITE_P(
    Modes, TravelLimitsMode,
    testing::Values(Row{"PositiveOff", kOff, kOff, at(900, 1, false, true), Reaction::kNone},
                    Row{"NegativeOff", kOff, kOff, at(-900, -1, true, false), Reaction::kNone},
                    Row{"PositiveDisables", kDisable, kOff, at(400, 1), Reaction::kDisable},
                    Row{"PositiveStops", kStop, kOff, at(400, 1), Reaction::kStop},
                    Row{"BeforeThePositive", kStop, kOff, at(399, 1), Reaction::kNone},
                    Row{"BackFromThePositive", kStop, kOff, at(420, -1), Reaction::kNone},
                    Row{"AtRestAtThePositive", kStop, kOff, at(420, 0), Reaction::kNone},
                    Row{"NegativeDisables", kDisable, kOff, at(-250, -1), Reaction::kDisable},
                    Row{"NegativeStops", kStop, kOff, at(-250, -1), Reaction::kStop},
                    Row{"BeforeTheNegative", kDisable, kOff, at(-249, -1), Reaction::kNone},
                    Row{"BackFromTheNegative", kDisable, kOff, at(-300, 1), Reaction::kNone},
                    Row{"PositiveSwitchStops", kOff, kStop, at(50, 1, false, true), Reaction::kStop},
                    Row{"PositiveSwitchDisables", kOff, kDisable, at(50, 1, false, true), Reaction::kDisable},
                    Row{"NegativeSwitchStops", kOff, kStop, at(50, -1, true, false), Reaction::kStop},
                    Row{"NegativeSwitchDisables", kOff, kDisable, at(50, -1, true, false), Reaction::kDisable},
                    Row{"BackFromThePositiveSwitch", kOff, kStop, at(50, -1, false, true), Reaction::kNone},
                    Row{"BackFromTheNegativeSwitch", kOff, kDisable, at(50, 1, true, false), Reaction::kNone},
                    Row{"TheStrongerOne", kStop, kDisable, at(400, 1, false, true), Reaction::kDisable},
                    Row{"TheStrongerOneOfSoftware", kDisable, kStop, at(400, 1, false, true), Reaction::kDisable}),
    [](const auto& row) { return row.param.name; });

TEST(TravelLimits, AStopBecomesAPowerOffButNotTheOtherWay) {
  TravelLimits limits;
  limits.configure({.software = kStop, .negative = -250, .positive = 400, .switches = kDisable});
  EXPECT_EQ(limits.step(at(405, 1)), Reaction::kStop);
  EXPECT_EQ(limits.step(at(410, 1, false, true)), Reaction::kDisable);
  EXPECT_EQ(limits.step(at(410, 1)), Reaction::kNone);
}

TEST(TravelLimits, EqualPositionsAreNoLimits) {
  TravelLimits limits;
  limits.configure({.software = kDisable, .negative = 30, .positive = 30});
  EXPECT_EQ(limits.step(at(900, 1)), Reaction::kNone);
  EXPECT_EQ(limits.step(at(-900, -1)), Reaction::kNone);
}

/// At 1000 counts/s the limit at 400 is seen at 400 or up to 2 counts behind it; 5000 counts/s^2 take 100 counts more.
TEST(TravelLimits, StopTheMotionOfTheAxisAndLetItGoBack) {
  Motion motion;
  motion.reset(-300.0);
  motion.enable(true);
  TravelLimits limits;
  limits.configure({.software = kStop, .negative = -1000, .positive = 400});
  const Move forth = {.target = 900, .velocity = 10'000, .acceleration = 1000, .deceleration = 500};
  const Move back = {.target = -200, .velocity = 10'000, .acceleration = 1000, .deceleration = 500};
  int stops = 0;
  const auto run = [&] {
    for (int i = 0; i < 1000; ++i) {
      motion.step(std::chrono::milliseconds{2});
      const ProfileState& now = motion.demand();
      const int direction = now.velocity > 0.0 ? 1 : now.velocity < 0.0 ? -1 : 0;
      if (limits.step(at(static_cast<std::int64_t>(now.position), direction)) == Reaction::kStop) {
        ++stops;
        motion.stop(500);
      }
    }
  };
  motion.add(forth);
  run();
  EXPECT_EQ(stops, 1);
  EXPECT_GE(motion.demand().position, 500.0 - 1e-6);
  EXPECT_LE(motion.demand().position, 502.0 + 1e-6);
  motion.add(back);
  run();
  EXPECT_EQ(stops, 1);
  EXPECT_EQ(motion.demand().position, -200.0);
}

}  // namespace
}  // namespace driveline::slaves::position_servo::travel_limits_test
