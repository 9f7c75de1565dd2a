#include "driveline/trajectory/limited_axis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

constexpr double kStep = 1e-3;
constexpr FollowLimits kBounds{{2.0, 100.0}, 1e4};

TEST(LimitedAxis, FollowsWhatKeepsTheLimitsToTheLastBit) {
  LimitedAxis axis(kBounds, kStep);
  axis.rest_at(1.0);
  double position = 1.0;
  for (int k = 1; k < 40; ++k) {
    const double velocity = 2.0 * std::min(k, 20) / 20.0;  // 100 rad/s^2 up to 2 rad/s
    position += velocity * kStep;
    test::expect_setpoint(axis.follow({position, velocity, 5.0}), {position, velocity, 5.0});
    ASSERT_TRUE(axis.on_target());
  }
}

TEST(LimitedAxis, LeavesWhatIsAPercentBeyondEitherLimit) {
  for (const double velocity : {0.101, -0.101}) {  // from rest in one step: 101 rad/s^2
    LimitedAxis axis(kBounds, kStep);
    axis.rest_at(0.0);
    EXPECT_NEAR(axis.follow({velocity * kStep, velocity, 0.0}).position, std::copysign(0.1, velocity) * kStep, 1e-6);
    EXPECT_FALSE(axis.on_target());
  }
  LimitedAxis axis(kBounds, kStep);
  axis.rest_at(0.0);
  double position = 0.0;
  for (int k = 1; k <= 20; ++k) (void)axis.follow({position += 0.1 * k * kStep, 0.1 * k, 0.0});
  ASSERT_TRUE(axis.on_target());
  (void)axis.follow({position + 2.02 * kStep, 2.02, 0.0});
  EXPECT_FALSE(axis.on_target());
}

TEST(LimitedAxis, ReportsNoMoreThanTheLimits) {
  LimitedAxis axis(kBounds, kStep);
  axis.rest_at(0.0);
  test::expect_setpoint(axis.follow({0.0, 1e3, -1e9}), {0.0, 2.0, -100.0});
}

TEST(LimitedAxis, StopsFromFullSpeedAndStaysThere) {
  LimitedAxis axis(kBounds, kStep);
  axis.rest_at(0.0);
  EXPECT_TRUE(axis.at_rest());
  double position = 0.0;
  for (int k = 1; k <= 60; ++k) {
    const double velocity = 0.1 * std::min(k, 20);
    (void)axis.follow({position += velocity * kStep, velocity, 0.0});
  }
  EXPECT_FALSE(axis.at_rest());
  double velocity = 2.0;
  int steps = 0;
  while (!axis.at_rest() && steps < 1000) {
    const AxisSetpoint now = axis.stop();
    const double next = (now.position - position) / kStep;
    ASSERT_LE(std::abs(next - velocity), 100.0 * kStep * (1.0 + 1e-9));
    position = now.position;
    velocity = next;
    ++steps;
  }
  // 2 rad/s at 100 rad/s^2, and 10 ms of rise and fall at 1e4 rad/s^3.
  EXPECT_NEAR(steps * kStep, 0.03, 2.0 * kStep);
  for (int k = 0; k < 10; ++k) test::expect_setpoint(axis.stop(), {position, 0.0, 0.0});
}

// The jerk would require more speed than allowed: the jerk limit yields.
TEST(LimitedAxis, AStopWhileItGainsSpeedKeepsTheSpeedLimit) {
  LimitedAxis axis({{2.0, 100.0}, 200.0}, kStep);
  axis.rest_at(0.0);
  double position = 0.0;
  for (int k = 1; k <= 19; ++k) (void)axis.follow({position += 0.1 * k * kStep, 0.1 * k, 100.0});
  ASSERT_TRUE(axis.on_target());
  double velocity = 1.9;
  double fastest = 0.0;
  for (int k = 0; k < 2000 && !axis.at_rest(); ++k) {
    const AxisSetpoint now = axis.stop();
    const double next = (now.position - position) / kStep;
    ASSERT_LE(std::abs(next - velocity), 100.0 * kStep * (1.0 + 1e-9));
    position = now.position;
    velocity = next;
    fastest = std::max(fastest, std::abs(velocity));
  }
  EXPECT_TRUE(axis.at_rest());
  EXPECT_GT(fastest, 1.99);
  EXPECT_LE(fastest, 2.0 * (1.0 + 1e-9));
}

TEST(LimitedAxis, FollowsAgainFromTheMiddleOfAStop) {
  LimitedAxis axis(kBounds, kStep);
  axis.rest_at(0.0);
  double position = 0.0;
  const auto target = [&](int k) {
    const double velocity = 0.1 * std::min(k, 10);
    return AxisSetpoint{position += velocity * kStep, velocity, 0.0};
  };
  double before = 0.0;
  double velocity = 0.0;
  for (int k = 1; k <= 400; ++k) {
    const AxisSetpoint wanted = target(k);
    const AxisSetpoint now = k > 50 && k <= 60 ? axis.stop() : axis.follow(wanted);
    const double next = (now.position - before) / kStep;
    ASSERT_LE(std::abs(next - velocity), 100.0 * kStep * (1.0 + 1e-9)) << k;
    ASSERT_LE(std::abs(next), 2.0 * (1.0 + 1e-9)) << k;
    before = now.position;
    velocity = next;
  }
  EXPECT_TRUE(axis.on_target());
  EXPECT_EQ(before, position);
}

}  // namespace
}  // namespace driveline::trajectory
