#include "driveline/slaves/signal.hpp"

#include <gtest/gtest.h>

namespace driveline::slaves {
namespace {

using namespace std::chrono_literals;

TEST(Signal, Constant) {
  const Signal signal{Signal::Shape::kConstant, 3.5, 99.0, 1s};
  EXPECT_DOUBLE_EQ(signal.at(0s), 3.5);
  EXPECT_DOUBLE_EQ(signal.at(1h), 3.5);
}

TEST(Signal, RampStartsAnewEachPeriod) {
  const Signal signal{Signal::Shape::kRamp, -10.0, 10.0, 4s};
  EXPECT_DOUBLE_EQ(signal.at(0s), -10.0);
  EXPECT_DOUBLE_EQ(signal.at(1s), -5.0);
  EXPECT_DOUBLE_EQ(signal.at(3s), 5.0);
  EXPECT_DOUBLE_EQ(signal.at(4s), -10.0);
}

TEST(Signal, SineReachesItsLimits) {
  const Signal signal{Signal::Shape::kSine, 100.0, 300.0, 4s};
  EXPECT_DOUBLE_EQ(signal.at(0s), 200.0);
  EXPECT_DOUBLE_EQ(signal.at(1s), 300.0);
  EXPECT_NEAR(signal.at(2s), 200.0, 1e-9);
  EXPECT_DOUBLE_EQ(signal.at(3s), 100.0);
}

TEST(Signal, ToggleIsLowFirst) {
  const Signal signal{Signal::Shape::kToggle, 0.0, 1.0, 10ms};
  EXPECT_DOUBLE_EQ(signal.at(0ms), 0.0);
  EXPECT_DOUBLE_EQ(signal.at(4999us), 0.0);
  EXPECT_DOUBLE_EQ(signal.at(5ms), 1.0);
  EXPECT_DOUBLE_EQ(signal.at(10ms), 0.0);
}

TEST(Signal, KeepsItsPhaseForYears) {
  const Signal signal{Signal::Shape::kToggle, 0.0, 1.0, 1ms};
  const auto years = std::chrono::nanoseconds{24h} * 3650;
  EXPECT_DOUBLE_EQ(signal.at(years), 0.0);
  EXPECT_DOUBLE_EQ(signal.at(years + 500us), 1.0);
}

TEST(Signal, StepsKeepTheirValueUntilTheNext) {
  Signal signal{Signal::Shape::kSteps, 7.0};
  signal.steps = {{10ms, 1.0}, {12ms, -2.0}};
  EXPECT_DOUBLE_EQ(signal.at(0ms), 7.0);
  EXPECT_DOUBLE_EQ(signal.at(10ms - 1ns), 7.0);
  EXPECT_DOUBLE_EQ(signal.at(10ms), 1.0);
  EXPECT_DOUBLE_EQ(signal.at(12ms), -2.0);
  EXPECT_DOUBLE_EQ(signal.at(1h), -2.0);
  EXPECT_DOUBLE_EQ(signal.smallest(), -2.0);
  EXPECT_DOUBLE_EQ(signal.largest(), 7.0);
}

TEST(Signal, NextJumpIsWhereTheValueChanges) {
  Signal steps{Signal::Shape::kSteps, 0.0};
  steps.steps = {{10ms, 1.0}, {12ms, 0.0}};
  EXPECT_EQ(steps.next_jump(0ms), 10ms);
  EXPECT_EQ(steps.next_jump(10ms), 12ms);
  EXPECT_EQ(steps.next_jump(12ms), std::nullopt);
  EXPECT_EQ((Signal{Signal::Shape::kConstant, 1.0}).next_jump(0ms), std::nullopt);
  for (const auto period : {Signal::Nanoseconds{7}, Signal::Nanoseconds{1}, Signal::Nanoseconds{1'000'000}}) {
    const Signal toggle{Signal::Shape::kToggle, 0.0, 1.0, period};
    Signal::Nanoseconds now{0};
    for (int i = 0; i < 20; ++i) {
      const auto next = toggle.next_jump(now);
      ASSERT_TRUE(next && *next > now);
      EXPECT_TRUE(period == 1ns || toggle.at(*next) > toggle.at(*next - 1ns) ||
                  toggle.at(*next) < toggle.at(*next - 1ns));
      EXPECT_EQ(toggle.at(*next - 1ns), toggle.at(now)) << "nothing before";
      now = *next;
    }
  }
}

}  // namespace
}  // namespace driveline::slaves
