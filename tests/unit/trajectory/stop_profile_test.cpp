#include "driveline/trajectory/stop_profile.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::expect_setpoint;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(StopProfile, WithoutJerkLimitTheVelocityFallsOnALine) {
  const StopProfile stop = StopProfile::plan({3.0, 10.0, 77.0}, {5.0, kInfinity}).value();
  EXPECT_EQ(stop.duration_s(), 2.0);
  EXPECT_EQ(stop.end_position(), 13.0);
  expect_setpoint(stop.evaluate(0.0), {3.0, 10.0, -5.0});
  expect_setpoint(stop.evaluate(1.0), {10.5, 5.0, -5.0});
  expect_setpoint(stop.evaluate(2.0), {13.0, 0.0, 0.0});
}

// Half a second to -5, 1.5 s there, half a second back; by symmetry the way is v T / 2.
TEST(StopProfile, WithJerkLimitTheAccelerationIsATrapezoid) {
  const StopProfile stop = StopProfile::plan({0.0, -10.0, 0.0}, {5.0, 10.0}).value();
  EXPECT_DOUBLE_EQ(stop.duration_s(), 2.5);
  EXPECT_DOUBLE_EQ(stop.end_position(), -12.5);
  expect_setpoint(stop.evaluate(0.25), {-2.5 + 10.0 * 0.25 * 0.25 * 0.25 / 6.0, -10.0 + 0.3125, 2.5});
  EXPECT_DOUBLE_EQ(stop.evaluate(1.25).velocity, -5.0);
  EXPECT_DOUBLE_EQ(stop.evaluate(1.25).acceleration, 5.0);
  EXPECT_DOUBLE_EQ(stop.evaluate(2.25).acceleration, 2.5);
  EXPECT_NEAR(stop.evaluate(2.25).velocity, -0.3125, 1e-14);
}

TEST(StopProfile, ASlowAxisNeverReachesTheFullDeceleration) {
  const StopProfile stop = StopProfile::plan({0.0, 1.0, 0.0}, {5.0, 4.0}).value();
  EXPECT_DOUBLE_EQ(stop.duration_s(), 1.0);
  EXPECT_DOUBLE_EQ(stop.end_position(), 0.5);
  EXPECT_DOUBLE_EQ(stop.evaluate(0.5).acceleration, -2.0);
}

TEST(StopProfile, AtStandstillThereIsNothingToDo) {
  for (const double jerk : {1.0, kInfinity}) {
    const StopProfile stop = StopProfile::plan({4.0, 0.0, 0.0}, {5.0, jerk}).value();
    EXPECT_EQ(stop.duration_s(), 0.0);
    expect_setpoint(stop.evaluate(0.0), {4.0, 0.0, 0.0});
    EXPECT_TRUE(stop.finished(0.0));
  }
}

// v = 1, a = -4, jerk 4: reducing the acceleration to zero takes 1 s and 2 of velocity, 1 more than available.
TEST(StopProfile, AnAxisAboutToReverseComesBack) {
  const StopProfile stop = StopProfile::plan({0.0, 1.0, -4.0}, {5.0, 4.0}).value();
  EXPECT_LT(stop.evaluate(0.8).velocity, 0.0);
  EXPECT_GT(stop.evaluate(stop.duration_s() - 0.1).acceleration, 0.0);
  // By hand: peak sqrt(4 * (-1 + 16 / 8)) = 2, so 6 / 4 s up and 2 / 4 s down.
  EXPECT_DOUBLE_EQ(stop.duration_s(), 2.0);
}

TEST(StopProfile, HoldsTheEndAndStartsAtZero) {
  const StopProfile stop = StopProfile::plan({3.0, 10.0, 1.0}, {5.0, 10.0}).value();
  for (const double before : {-kInfinity, -1.0, kNan}) {
    expect_setpoint(stop.evaluate(before), {3.0, 10.0, 1.0});
    EXPECT_FALSE(stop.finished(before));
  }
  for (const double after : {stop.duration_s(), 1e9, kInfinity}) {
    expect_setpoint(stop.evaluate(after), {stop.end_position(), 0.0, 0.0});
    EXPECT_TRUE(stop.finished(after));
  }
}

TEST(StopProfile, RefusesWhatItCannotPlan) {
  EXPECT_FALSE(StopProfile::plan({kNan, 0.0, 0.0}, {1.0, 1.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, kInfinity, 0.0}, {1.0, 1.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 0.0, kNan}, {1.0, 1.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 1.0, 0.0}, {}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 1.0, 0.0}, {-1.0, 1.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 1.0, 0.0}, {kInfinity, 1.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 1.0, 0.0}, {kNan, 1.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 1.0, 0.0}, {1.0, 0.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 1.0, 0.0}, {1.0, kNan}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 1e200, 0.0}, {1.0, 1.0}).has_value());
  EXPECT_FALSE(StopProfile::plan({0.0, 0.0, 1e200}, {1.0, 1.0}).has_value());
}

/// Steps through a stop; checks bounds and that the reported quantities are each other's integrals.
void check_motion(const StopProfile& stop, const AxisSetpoint& from, const StopLimits& limits) {
  constexpr int kSteps = 4000;
  const double step = stop.duration_s() / kSteps;
  const bool is_jerk_limited = std::isfinite(limits.max_jerk);
  const double a_max = std::max(limits.max_deceleration, is_jerk_limited ? std::abs(from.acceleration) : 0.0);
  const double v_max = std::abs(from.velocity) + a_max * stop.duration_s();
  const double v_rest = is_jerk_limited
                            ? from.velocity + from.acceleration * std::abs(from.acceleration) / (2.0 * limits.max_jerk)
                            : from.velocity;
  const double direction = v_rest < 0.0 ? -1.0 : 1.0;
  AxisSetpoint last = stop.evaluate(0.0);
  EXPECT_EQ(last.position, from.position);
  EXPECT_EQ(last.velocity, from.velocity);
  for (int k = 1; k <= kSteps; ++k) {
    const AxisSetpoint at = stop.evaluate(k * step);
    ASSERT_LE(std::abs(at.acceleration), a_max * (1.0 + 1e-9));
    ASSERT_NEAR(at.position - last.position, (at.velocity + last.velocity) / 2.0 * step,
                a_max * step * step + 1e-12 * std::abs(at.position));
    ASSERT_NEAR(at.velocity - last.velocity, (at.acceleration + last.acceleration) / 2.0 * step,
                1.01 * a_max * step + 1e-12 * v_max);
    if (is_jerk_limited) {
      ASSERT_LE(std::abs(at.acceleration - last.acceleration), limits.max_jerk * step * (1.0 + 1e-6) + 1e-9 * a_max);
      ASSERT_NEAR(at.velocity - last.velocity, (at.acceleration + last.acceleration) / 2.0 * step,
                  limits.max_jerk * step * step + 1e-11 * v_max);
    }
    if (from.velocity * direction >= 0.0) {
      ASSERT_GE(at.velocity * direction, -1e-9 * v_max) << "the axis reverses without need";
    }
    last = at;
  }
  EXPECT_NEAR(last.velocity, 0.0, 1e-9 * v_max);
  EXPECT_NEAR(last.position, stop.end_position(), 1e-9 * std::max(1.0, v_max * stop.duration_s()));
  expect_setpoint(stop.evaluate(stop.duration_s()), {stop.end_position(), 0.0, 0.0});
}

TEST(StopProfile, StopsFromAnyStateWithinTheBounds) {
  test::Random random;
  for (int round = 0; round < 500; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const AxisSetpoint from{random.real(-100.0, 100.0), random.real(-200.0, 200.0), random.real(-3000.0, 3000.0)};
    StopLimits limits{random.magnitude(10.0, 5000.0)};
    if (random.index(0, 2) > 0) {
      limits.max_jerk = random.magnitude(100.0, 1e6);
    }
    const auto stop = StopProfile::plan(from, limits);
    ASSERT_TRUE(stop.has_value());
    check_motion(*stop, from, limits);
    if (testing::Test::HasFailure()) {
      return;
    }
  }
}

}  // namespace
}  // namespace driveline::trajectory
