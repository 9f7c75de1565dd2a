// Setpoints generated from the commands of tasks.
#include "driveline/motion/path/driven_axes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace driveline::motion {
namespace {

using trajectory::AxisSetpoint;

constexpr double kPeriodSeconds = 125e-6;

/// Two axes: one commanded in every cycle, one in every fourth.
class DrivenAxesTest : public testing::Test {
 protected:
  void begin_at(double first, double second) {
    setpoints = {AxisSetpoint{first, 0.0, 0.0}, AxisSetpoint{second, 0.0, 0.0}};
    axes.rewind(setpoints);
    axes.begin(true);
  }
  void step() { EXPECT_TRUE(axes.next({0.0, {}}, setpoints)); }

  DrivenAxes axes{{1, 4}, kPeriodSeconds};
  std::array<AxisSetpoint, 2> setpoints{};
};

TEST_F(DrivenAxesTest, HoldTheirPlaceUntilTheyAreCommanded) {
  begin_at(1.5, -2.0);
  for (int i = 0; i < 5; ++i) step();
  EXPECT_DOUBLE_EQ(setpoints[0].position, 1.5);
  EXPECT_DOUBLE_EQ(setpoints[1].position, -2.0);
  EXPECT_DOUBLE_EQ(setpoints[1].velocity, 0.0);
  EXPECT_FALSE(setpoints[0].torque.has_value());
}

TEST_F(DrivenAxesTest, ACommandOfEveryCycleGoesOutAsItIs) {
  begin_at(0.0, 0.0);
  axes.axis(0).command({0.25, 3.0, -7.0, 0.5});
  step();
  EXPECT_DOUBLE_EQ(setpoints[0].position, 0.25);
  EXPECT_DOUBLE_EQ(setpoints[0].velocity, 3.0);
  EXPECT_DOUBLE_EQ(setpoints[0].acceleration, -7.0);
  EXPECT_DOUBLE_EQ(*setpoints[0].torque, 0.5);
  step();
  EXPECT_DOUBLE_EQ(setpoints[0].position, 0.25) << "until the next one";
}

TEST_F(DrivenAxesTest, ASlowerCommandIsArrivedAtOnAStraightLine) {
  begin_at(0.0, 1.0);
  axes.axis(1).command({1.4, 99.0, 0.0, 2.0});
  for (const double place : {1.1, 1.2, 1.3, 1.4}) {
    step();
    EXPECT_NEAR(setpoints[1].position, place, 1e-12);
    EXPECT_NEAR(setpoints[1].velocity, 0.1 / kPeriodSeconds, 1e-6) << "that of the way, not what was commanded";
    EXPECT_DOUBLE_EQ(*setpoints[1].torque, 2.0) << "at once";
  }
  EXPECT_DOUBLE_EQ(setpoints[1].position, 1.4) << "exactly";
  step();
  EXPECT_DOUBLE_EQ(setpoints[1].position, 1.4);
  EXPECT_DOUBLE_EQ(setpoints[1].velocity, 0.0) << "a task that is late leaves the axis where it is";
  // A command that comes before the last one was reached starts at the present position.
  axes.axis(1).command({2.4, 0.0, 0.0});
  step();
  axes.axis(1).command({1.65, 0.0, 0.0});
  step();
  EXPECT_NEAR(setpoints[1].position, 1.65, 1e-12);
}

TEST_F(DrivenAxesTest, CommandsCountOnlyWhileTheAxesFollow) {
  begin_at(1.0, 1.0);
  EXPECT_TRUE(axes.axis(0).followed());
  axes.axis(0).command({1.1, 0.0, 0.0});
  step();
  axes.end();
  EXPECT_FALSE(axes.axis(0).followed());
  axes.axis(0).command({50.0, 0.0, 0.0});
  // Enabled again at another position.
  setpoints = {AxisSetpoint{3.0, 0.0, 0.0}, AxisSetpoint{4.0, 0.0, 0.0}};
  axes.rewind(setpoints);
  axes.axis(0).command({60.0, 0.0, 0.0});
  axes.begin(true);
  step();
  EXPECT_DOUBLE_EQ(setpoints[0].position, 3.0);
  EXPECT_DOUBLE_EQ(setpoints[1].position, 4.0);
}

TEST_F(DrivenAxesTest, TellTheirTasksToComeToRest) {
  setpoints = {};
  axes.rewind(setpoints);
  EXPECT_FALSE(axes.axis(1).to_rest());
  axes.begin(false);
  EXPECT_TRUE(axes.axis(1).followed());
  EXPECT_TRUE(axes.axis(1).to_rest());
  axes.run(true);
  EXPECT_FALSE(axes.axis(1).to_rest());
  axes.run(false);
  axes.end();
  EXPECT_FALSE(axes.axis(1).to_rest());
}

TEST_F(DrivenAxesTest, NumbersThatAreNoneArePassedOnToBeRefused) {
  begin_at(0.0, 0.0);
  axes.axis(1).command({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
  step();
  EXPECT_TRUE(std::isnan(setpoints[1].position));
}

}  // namespace
}  // namespace driveline::motion
