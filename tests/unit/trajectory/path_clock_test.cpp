#include "driveline/trajectory/path_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driveline::trajectory {
namespace {

constexpr double kStep = 125e-6;

TEST(PathClock, IsExactlyTheTimeThatHasPassedWhileItRuns) {
  PathClock clock(0.1);
  clock.start(0.0, 0.25, true);
  for (int i = 1; i <= 1000; ++i) EXPECT_EQ(clock.advance(kStep * i), 0.25 + kStep * i);
  const AxisSetpoint setpoint{1.0, 2.0, 3.0};
  EXPECT_EQ(clock.scaled(setpoint).velocity, 2.0);
  EXPECT_EQ(clock.scaled(setpoint).acceleration, 3.0);
}

TEST(PathClock, ComesToRestAndGoesOnFromThere) {
  PathClock clock(0.1);
  clock.start(0.0, 0.0, true);
  clock.run(false);
  double now = 0.0;
  while (!clock.at_rest()) clock.advance(now += kStep);
  EXPECT_NEAR(now, 0.1, 2 * kStep);
  EXPECT_NEAR(clock.path_s(), 0.05, 1e-6) << "the mean speed is half of the full one";
  const double rest = clock.path_s();
  for (int i = 0; i < 100; ++i) EXPECT_EQ(clock.advance(now += kStep), rest);
  EXPECT_EQ(clock.scaled({1.0, 2.0, 3.0}).velocity, 0.0);
  EXPECT_EQ(clock.scaled({1.0, 2.0, 3.0}).acceleration, 0.0);
  clock.run(true);
  for (int i = 0; i < 8000; ++i) clock.advance(now += kStep);
  EXPECT_NEAR(clock.path_s(), rest + 1.0 - 0.05, 1e-6);
}

TEST(PathClock, ATurnOnTheWayIsNoJump) {
  PathClock clock(0.1);
  clock.start(0.0, 0.0, true);
  double now = 0.0;
  double before = 0.0;
  double rate = 1.0;
  for (int i = 0; i < 4000; ++i) {
    clock.run(i / 300 % 2 == 1);
    const double path = clock.advance(now += kStep);
    const double next = (path - before) / kStep;
    EXPECT_LE(std::abs(next - rate), 1.01 * kStep / 0.1);
    EXPECT_GE(next, -1e-12);
    rate = next;
    before = path;
  }
}

TEST(PathClock, StaysLateUnlessItIsToCatchUp) {
  PathClock clock(0.1);
  clock.start(0.0, 0.0, true);
  clock.fall_behind(0.05);
  for (int i = 1; i <= 1000; ++i) EXPECT_EQ(clock.advance(kStep * i), kStep * i);
  EXPECT_EQ(clock.behind_s(), 0.05);
}

TEST(PathClock, CatchesUpByWhatItIsLate) {
  for (const double late : {0.0002, 0.003, 0.05, 0.4}) {
    PathClock clock(0.02, 1.2);
    clock.start(0.0, 0.0, true);
    double now = 0.0;
    double before = 0.0;
    double rate = 1.0;
    double fastest = 1.0;
    for (int i = 0; i < 40000; ++i) {
      if (i == 800) clock.fall_behind(late);
      if (i == 1200) clock.run(false);
      if (i == 1600) clock.run(true);
      const double path = clock.advance(now += kStep);
      const double next = (path - before) / kStep;
      const bool gently = rate > 1.0 + 1e-9 && next > 1.0 + 1e-9;
      ASSERT_LE(std::abs(next - rate), 1.01 * kStep / 0.02 / (gently ? 4.0 : 1.0)) << i;
      fastest = std::max(fastest, next);
      rate = next;
      before = path;
    }
    EXPECT_LE(fastest, 1.2 + 1e-9);
    EXPECT_NEAR(rate, 1.0, 1e-9);
    EXPECT_NEAR(clock.behind_s(), 0.0, 0.2 * kStep) << late;
    // Deliberate standstill, counted from the time when the path was no faster than at full speed, is not caught up.
    EXPECT_NEAR(clock.path_s() - now, late - 400 * kStep, 4.0 * 0.2 * 0.02 + 2 * kStep) << late;
  }
}

/// A raised cosine of one second.
Interpolator cosine(double amplitude) {
  PathBuilder builder;
  EXPECT_TRUE(builder.add_axis({"a", AxisKind::kRotary}).has_value());
  for (int i = 0; i <= 200; ++i) {
    const double position = amplitude * 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * i / 200.0));
    EXPECT_TRUE(builder.add_point(i / 200.0, std::array{position}).has_value());
  }
  return Interpolator::clamped_spline(*builder.build());
}

TEST(PathClock, TheRampKeepsEveryAxisWithinItsLimitsWhereverItBegins) {
  auto path = cosine(2.0);
  // The path itself needs 2 pi rad/s and 39.5 rad/s^2.
  const std::array limits{AxisLimits{10.0, 60.0}};
  const double ramp = path_ramp_s(path, limits);
  EXPECT_NEAR(ramp, 2.0 * std::numbers::pi / (60.0 - 39.5), 0.01);
  for (int begin = 0; begin < 20; ++begin) {
    PathClock clock(ramp);
    clock.start(0.0, 0.0, true);
    double velocity = 0.0;
    double position = 0.0;
    for (int i = 1; i < 24000 && !path.finished(clock.path_s()); ++i) {
      clock.run(i * kStep < begin * 0.05 || i * kStep > begin * 0.05 + 0.5);
      std::array<AxisSetpoint, 1> setpoint{};
      path.evaluate(clock.advance(i * kStep), setpoint);
      const double next = (setpoint[0].position - position) / kStep;
      ASSERT_LE(std::abs(next - velocity) / kStep, 60.0 * 1.02) << "begin " << begin << " at " << i * kStep;
      ASSERT_NEAR(clock.scaled(setpoint[0]).velocity, next, 60.0 * kStep);
      velocity = next;
      position = setpoint[0].position;
    }
  }
}

TEST(PathCatchUpRate, LeavesEveryAxisWithinItsLimits) {
  const double peak_velocity = std::numbers::pi;
  const double peak_acceleration = 2.0 * std::numbers::pi * std::numbers::pi;
  const auto rate_of = [&](double velocity, double acceleration) {
    const std::vector<AxisLimits> limits{{velocity * peak_velocity, acceleration * peak_acceleration}};
    return path_catch_up_rate(cosine(1.0), limits, path_ramp_s(cosine(1.0), limits));
  };
  EXPECT_DOUBLE_EQ(rate_of(10.0, 10.0), 1.25);
  EXPECT_NEAR(rate_of(1.1, 10.0), 1.1, 1e-3) << "the velocity is the limit";
  const double rate = rate_of(10.0, 1.5);
  EXPECT_GT(rate, 1.0);
  EXPECT_LT(rate * rate, 1.5) << "the acceleration is";
  EXPECT_EQ(rate_of(1.0, 1.0), 1.0) << "nothing is left";
}

}  // namespace
}  // namespace driveline::trajectory
