#include "driveline/trajectory/motion_limits.hpp"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::require;

Path two_points() {
  PathBuilder builder;
  require(builder.add_axis({"lift", AxisKind::kLinear}));
  require(builder.add_axis({"x", AxisKind::kRotary}));
  require(builder.add_point(1.0, std::array{0.5, 0.0}));
  require(builder.add_point(2.0, std::array{0.0, 2.0}));
  return builder.build().value();
}

std::string verdict(Interpolator interpolator, AxisLimits lift, AxisLimits x, double period_s = 0.001) {
  const auto result = check_limits(interpolator, std::array{lift, x}, period_s);
  return result ? "accepted" : result.error().message();
}

// From 0 to D in T = 1 s with standstill at the ends: v_max = 1.5 D / T in the middle, a = +-6 D / T^2 at the ends.
TEST(CheckLimits, AcceptsExactlyWhatTheCubicNeeds) {
  const Interpolator spline = Interpolator::clamped_spline(two_points());
  EXPECT_EQ(verdict(spline, {0.75, 3.0}, {3.0, 12.0}), "accepted");
  EXPECT_EQ(verdict(spline, {}, {}), "accepted");
}

TEST(CheckLimits, NamesAxisTimeValueAndLimit) {
  const Interpolator spline = Interpolator::clamped_spline(two_points());
  EXPECT_EQ(verdict(spline, {}, {2.25, 12.0}, 0.125),
            "axis 'x' would need a velocity of 3 rad/s at 1.5 s; its limit is 2.25 rad/s");
  EXPECT_EQ(verdict(spline, {}, {2.999999, 12.0}),
            "axis 'x' would need a velocity of 3 rad/s at 1.5 s; its limit is 3 rad/s");
  EXPECT_EQ(verdict(spline, {0.5, 3.0}, {}, 0.25),
            "axis 'lift' would need a velocity of -0.75 m/s at 1.5 s; its limit is 0.5 m/s");
  EXPECT_EQ(verdict(spline, {0.75, 2.5}, {}),
            "axis 'lift' would need an acceleration of -3 m/s^2 at 1 s; its limit is 2.5 m/s^2");
}

TEST(CheckLimits, GivesTheFactsOfWhatIsTooMuch) {
  Interpolator spline = Interpolator::clamped_spline(two_points());
  const auto result = check_limits(spline, std::array{AxisLimits{}, AxisLimits{2.25, 100.0}}, 0.25);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().axis_index, 1U);
  EXPECT_EQ(result.error().axis.name, "x");
  EXPECT_EQ(result.error().quantity, LimitViolation::Quantity::kVelocity);
  EXPECT_EQ(result.error().time_s, 1.5);
  EXPECT_EQ(result.error().value, 3.0);
  EXPECT_EQ(result.error().limit, 2.25);
}

// Slowing the path down by the reported excess is sufficient.
TEST(CheckLimits, TellsTheMostOfWhatIsTooMuchFirst) {
  PathBuilder builder;
  require(builder.add_axis({"x", AxisKind::kRotary}));
  require(builder.add_axis({"y", AxisKind::kRotary}));
  double position = 0.0;
  for (const double time : {0.0, 1.0, 2.0, 3.0}) {
    position += time * time;
    require(builder.add_point(time, std::array{position, 100.0 * position}));
  }
  Interpolator line = Interpolator::linear(builder.build().value());
  const auto result = check_limits(line, std::array{AxisLimits{0.9, 1e9}, AxisLimits{800.0, 1e9}}, 1.0 / 1024.0);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().axis.name, "x") << "y is too fast only later";
  EXPECT_EQ(result.error().value, 9.0);
  EXPECT_GE(result.error().time_s, 2.0);
}

// A linear path reports no acceleration, yet its corners are jumps: 2 rad/s within 1 ms at the start.
TEST(CheckLimits, FindsTheCornersOfALinearPath) {
  const Interpolator line = Interpolator::linear(two_points());
  EXPECT_EQ(verdict(line, {}, {2.0, 2000.1}, 1.0 / 1024.0),
            "axis 'x' would need an acceleration of 2048 rad/s^2 at 1 s; its limit is 2000.1 rad/s^2");
  EXPECT_EQ(verdict(line, {}, {2.0, 2048.0}, 1.0 / 1024.0), "accepted");
}

TEST(CheckLimits, SeesTheStopAfterTheLastPoint) {
  const Interpolator spline = Interpolator::clamped_spline(two_points(), {}, std::array{-0.5, 20.0});
  const auto end_jump = verdict(spline, {}, {100.0, 1000.0}, 1.0 / 1024.0);
  EXPECT_EQ(end_jump.rfind("axis 'x' would need an acceleration of -", 0), 0U) << end_jump;
  EXPECT_NE(end_jump.find(" rad/s^2 at 2 s; its limit is 1000 rad/s^2"), std::string::npos) << end_jump;
}

TEST(CheckLimits, RefusesLimitsAndPeriodsThatMakeNoSense) {
  Interpolator spline = Interpolator::clamped_spline(two_points());
  const AxisLimits good{1e9, 1e9};
  EXPECT_THROW((void)check_limits(spline, std::array{good}, 0.001), std::invalid_argument);
  EXPECT_THROW((void)check_limits(spline, std::array{good, AxisLimits{0.0, 1.0}}, 0.001), std::invalid_argument);
  EXPECT_THROW((void)check_limits(spline, std::array{good, AxisLimits{1.0, -1.0}}, 0.001), std::invalid_argument);
  EXPECT_THROW((void)check_limits(spline, std::array{good, AxisLimits{std::nan(""), 1.0}}, 0.001),
               std::invalid_argument);
  for (const double period_s : {0.0, -1.0, 0.99e-6, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((void)check_limits(spline, std::array{good, good}, period_s), std::invalid_argument);
  }
}

}  // namespace
}  // namespace driveline::trajectory
