#include "driveline/motion/control/return_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace driveline::motion {
namespace {

using cia402::Mode;
using trajectory::AxisSetpoint;

constexpr double kBackStep = 125e-6;
constexpr trajectory::AxisLimits kBackLimits{50.0, 1000.0};

/// A motion at 10 rad/s.
AxisSetpoint at_ten(int step) {
  return {10.0 * step * kBackStep, 10.0, 0.0};
}

/// The return path of an axis that lags by 5 mrad.
ReturnMotion from_behind(Mode mode) {
  AxisConfig config;
  config.mode = mode;
  config.limits = kBackLimits;
  SetpointSupply supply(config, kBackStep);
  for (int i = -1; i <= 0; ++i) supply.note({at_ten(i).position - 5e-3, 10.0, 0.0}, mode);
  return {supply, kBackLimits};
}

/// The highest acceleration of the return, which ends within a second; `changing` from this step on.
double hardest(ReturnMotion motion, int changing = 8000) {
  double velocity = 10.0;
  double most = 0.0;
  for (int i = 1; i < 8000 && !motion.joined(); ++i) {
    const auto setpoint = motion.step(at_ten(i), kBackStep, i >= changing);
    if (!motion.joined() && i > changing) most = std::max(most, std::abs(setpoint.velocity - velocity) / kBackStep);
    if (changing == 8000) most = std::max(most, std::abs(setpoint.velocity - velocity) / kBackStep);
    velocity = setpoint.velocity;
  }
  EXPECT_TRUE(motion.joined());
  return most;
}

TEST(ReturnMotion, TakesAllTheLimitsWhereADriveFollowsAtOnceAndATenthInCst) {
  EXPECT_GT(hardest(from_behind(Mode::kCyclicPosition)), 0.9 * kBackLimits.max_acceleration);
  EXPECT_GT(hardest(from_behind(Mode::kCyclicVelocity)), 0.9 * kBackLimits.max_acceleration);
  EXPECT_LE(hardest(from_behind(Mode::kCyclicTorque)), 0.11 * kBackLimits.max_acceleration);
}

/// The change of mode needs some of the acceleration itself.
TEST(ReturnMotion, IsGentleFromAChangeOfModeOn) {
  EXPECT_LE(hardest(from_behind(Mode::kCyclicPosition), 1), 0.11 * kBackLimits.max_acceleration);
  EXPECT_LE(hardest(from_behind(Mode::kCyclicPosition), 20), 0.11 * kBackLimits.max_acceleration);
}

/// A motion that restarts while an axis returns makes a step.
TEST(ReturnMotion, DoesNotLeapWithAMotionThatDoes) {
  auto motion = from_behind(Mode::kCyclicTorque);
  AxisSetpoint last = at_ten(0);
  last.position -= 5e-3;
  for (int i = 1; i < 4000; ++i) {
    auto target = at_ten(i);
    if (i >= 40) target = {-0.2, 0.0, 0.0};
    const auto setpoint = motion.step(target, kBackStep, false);
    EXPECT_NEAR(setpoint.velocity, last.velocity, 0.11 * kBackLimits.max_acceleration * kBackStep) << i;
    EXPECT_NEAR(setpoint.position, last.position + setpoint.velocity * kBackStep, 1e-4 * kBackStep) << i;
    last = setpoint;
  }
}

}  // namespace
}  // namespace driveline::motion
