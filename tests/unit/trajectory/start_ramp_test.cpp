#include "driveline/trajectory/start_ramp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::expect_setpoint;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Duration by hand: velocity requires 15/8 * 8 / 15 = 1 s, acceleration sqrt(10/sqrt(3) * 8 / 100) = 0.68 s.
TEST(StartRamp, FollowsTheQuinticByHand) {
  const StartRamp ramp = StartRamp::plan(2.0, 10.0, {15.0, 100.0}).value();
  EXPECT_DOUBLE_EQ(ramp.duration_s(), 1.0);
  expect_setpoint(ramp.evaluate(0.0), {2.0, 0.0, 0.0});
  expect_setpoint(ramp.evaluate(0.25), {2.0 + 8.0 * 53.0 / 512.0, 8.0 * 135.0 / 128.0, 8.0 * 5.625});
  expect_setpoint(ramp.evaluate(0.5), {6.0, 15.0, 0.0});
  expect_setpoint(ramp.evaluate(1.0), {10.0, 0.0, 0.0});
}

TEST(StartRamp, HoldsBeforeAndAfter) {
  const StartRamp ramp = StartRamp::plan(2.0, -3.0, {1.0, 1.0}).value();
  for (const double before : {-kInfinity, -1.0, 0.0, kNan}) {
    expect_setpoint(ramp.evaluate(before), {2.0, 0.0, 0.0});
    EXPECT_FALSE(ramp.finished(before));
  }
  for (const double after : {ramp.duration_s(), 1e9, kInfinity}) {
    expect_setpoint(ramp.evaluate(after), {-3.0, 0.0, 0.0});
    EXPECT_TRUE(ramp.finished(after));
  }
}

TEST(StartRamp, NoWayTakesNoTime) {
  const StartRamp ramp = StartRamp::plan(7.0, 7.0, {1.0, 1.0}).value();
  EXPECT_EQ(ramp.duration_s(), 0.0);
  EXPECT_TRUE(ramp.finished(0.0));
  expect_setpoint(ramp.evaluate(0.0), {7.0, 0.0, 0.0});
}

TEST(StartRamp, StretchesButNeverShortens) {
  StartRamp ramp = StartRamp::plan(0.0, 8.0, {15.0, 100.0}).value();
  for (const double ignored : {0.5, -1.0, 0.0, kNan, kInfinity}) {
    ramp.stretch_to(ignored);
    EXPECT_DOUBLE_EQ(ramp.duration_s(), 1.0);
  }
  ramp.stretch_to(2.0);
  EXPECT_EQ(ramp.duration_s(), 2.0);
  expect_setpoint(ramp.evaluate(1.0), {4.0, 7.5, 0.0});
}

TEST(StartRamp, RefusesWhatItCannotPlan) {
  EXPECT_FALSE(StartRamp::plan(kNan, 0.0, {1.0, 1.0}).has_value());
  EXPECT_FALSE(StartRamp::plan(0.0, kInfinity, {1.0, 1.0}).has_value());
  EXPECT_FALSE(StartRamp::plan(0.0, 1.0, {0.0, 1.0}).has_value());
  EXPECT_FALSE(StartRamp::plan(0.0, 1.0, {1.0, -1.0}).has_value());
  EXPECT_FALSE(StartRamp::plan(0.0, 1.0, {kNan, 1.0}).has_value());
  EXPECT_FALSE(StartRamp::plan(0.0, 1.0, {1.0, kInfinity}).has_value());
  EXPECT_FALSE(StartRamp::plan(0.0, 1.0, {kInfinity, 1.0}).has_value());
  EXPECT_FALSE(StartRamp::plan(0.0, 1.0, {1e-320, 1.0}).has_value());
  EXPECT_FALSE(StartRamp::plan(-1e308, 1e308, {1.0, 1.0}).has_value());
}

TEST(StartRamp, UsesTheLimitsAndKeepsThem) {
  test::Random random;
  for (int round = 0; round < 300; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const double from = random.real(-100.0, 100.0);
    const double to = random.real(-100.0, 100.0);
    const AxisLimits limits{random.magnitude(0.1, 300.0), random.magnitude(0.1, 5000.0)};
    const StartRamp ramp = StartRamp::plan(from, to, limits).value();
    const double step = ramp.duration_s() / 2000.0;
    double peak_velocity = 0.0;
    double peak_acceleration = 0.0;
    for (int k = 1; k < 2000; ++k) {
      const AxisSetpoint before = ramp.evaluate((k - 1) * step);
      const AxisSetpoint at = ramp.evaluate(k * step);
      const AxisSetpoint after = ramp.evaluate((k + 1) * step);
      peak_velocity = std::max(peak_velocity, std::abs(at.velocity));
      peak_acceleration = std::max(peak_acceleration, std::abs(at.acceleration));
      ASSERT_GE((after.position - at.position) * (to - from), -1e-9);
      // Differences of the neighbours, with the error of the central formula (third derivative <= 60 D / T^3).
      ASSERT_NEAR(at.velocity, (after.position - before.position) / (2.0 * step), 1e-4 * limits.max_velocity);
      ASSERT_NEAR(at.acceleration, (after.velocity - before.velocity) / (2.0 * step), 1e-4 * limits.max_acceleration);
    }
    EXPECT_LE(peak_velocity, limits.max_velocity * (1.0 + 1e-12));
    EXPECT_LE(peak_acceleration, limits.max_acceleration * (1.0 + 1e-12));
    EXPECT_GT(std::max(peak_velocity / limits.max_velocity, peak_acceleration / limits.max_acceleration), 0.999);
  }
}

}  // namespace
}  // namespace driveline::trajectory
