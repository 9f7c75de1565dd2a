#include "driveline/slaves/generic/signal.hpp"

#include <gtest/gtest.h>

namespace driveline::slaves::generic {
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

}  // namespace
}  // namespace driveline::slaves::generic
