#include "driveline/trajectory/interpolator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::evaluate_all;
using test::evaluate_one;
using test::expect_setpoint;
using test::make_path;
using test::sample_path;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Path two_axis_path() {
  return make_path(std::array{1.0, 2.0, 4.0}, {{0.0, 10.0}, {2.0, 10.0}, {-2.0, 30.0}});
}

TEST(LinearInterpolator, FollowsStraightLines) {
  Interpolator line = Interpolator::linear(two_axis_path());
  EXPECT_EQ(line.start_s(), 1.0);
  EXPECT_EQ(line.end_s(), 4.0);
  EXPECT_EQ(line.duration_s(), 3.0);
  ASSERT_EQ(line.axes().size(), 2U);
  EXPECT_EQ(line.axes()[1].name, "a1");

  auto now = evaluate_all(line, 1.25);
  expect_setpoint(now[0], {0.5, 2.0, 0.0});
  expect_setpoint(now[1], {10.0, 0.0, 0.0});
  now = evaluate_all(line, 2.0);  // a corner belongs to the segment that starts there
  expect_setpoint(now[0], {2.0, -2.0, 0.0});
  expect_setpoint(now[1], {10.0, 10.0, 0.0});
  now = evaluate_all(line, 3.5);
  expect_setpoint(now[0], {-1.0, -2.0, 0.0});
  expect_setpoint(now[1], {25.0, 10.0, 0.0});
}

TEST(Interpolator, HoldsTheFirstAndTheLastPointAtStandstill) {
  const Path path = two_axis_path();
  for (Interpolator interpolator : {Interpolator::linear(path), Interpolator::natural_spline(path),
                                    Interpolator::clamped_spline(path, std::array{1.0, 2.0}, std::array{3.0, 4.0})}) {
    for (const double before : {-kInfinity, -1.0, std::nextafter(1.0, 0.0)}) {
      expect_setpoint(evaluate_all(interpolator, before)[0], {0.0, 0.0, 0.0});
      expect_setpoint(evaluate_all(interpolator, before)[1], {10.0, 0.0, 0.0});
      EXPECT_FALSE(interpolator.finished(before));
    }
    EXPECT_NE(evaluate_all(interpolator, 1.0)[0].velocity, 0.0);
    EXPECT_FALSE(interpolator.finished(std::nextafter(4.0, 0.0)));
    for (const double after : {4.0, 5.0, kInfinity}) {
      expect_setpoint(evaluate_all(interpolator, after)[0], {-2.0, 0.0, 0.0});
      expect_setpoint(evaluate_all(interpolator, after)[1], {30.0, 0.0, 0.0});
      EXPECT_TRUE(interpolator.finished(after));
    }
    EXPECT_FALSE(interpolator.finished(kNan));
  }
}

TEST(Interpolator, NanRepeatsThePreviousTime) {
  Interpolator spline = Interpolator::natural_spline(two_axis_path());
  expect_setpoint(evaluate_one(spline, kNan), evaluate_one(spline, 1.0));  // never called before: the start
  const AxisSetpoint at = evaluate_one(spline, 2.5);
  expect_setpoint(evaluate_one(spline, kNan), at);
  const AxisSetpoint end = evaluate_one(spline, 9.0);
  expect_setpoint(evaluate_one(spline, kNan), end);
}

TEST(Interpolator, WritesNoMoreThanAxesAndSpanHave) {
  Interpolator spline = Interpolator::natural_spline(two_axis_path());
  const auto whole = evaluate_all(spline, 2.5);
  for (const double time_s : {0.0, 2.5, 9.0}) {
    std::array<AxisSetpoint, 3> out{};
    out.fill({7.0, 8.0, 9.0});
    spline.evaluate(time_s, std::span(out).first(1));
    expect_setpoint(out[1], {7.0, 8.0, 9.0});
    spline.evaluate(time_s, out);
    expect_setpoint(out[2], {7.0, 8.0, 9.0});
    spline.evaluate(time_s, {});
  }
  std::array<AxisSetpoint, 1> first{};
  spline.evaluate(2.5, first);
  expect_setpoint(first[0], whole[0]);
}

// s(x) = 3 x^2 - 2 x^3: the cubic with standstill at both ends.
TEST(ClampedSpline, OfTwoPointsIsTheHermiteCubic) {
  Interpolator spline = Interpolator::clamped_spline(make_path(std::array{0.0, 2.0}, {{1.0}, {5.0}}));
  expect_setpoint(evaluate_one(spline, 0.0), {1.0, 0.0, 6.0});
  expect_setpoint(evaluate_one(spline, 0.5), {1.625, 2.25, 3.0});
  expect_setpoint(evaluate_one(spline, 1.0), {3.0, 3.0, 0.0});
  expect_setpoint(evaluate_one(spline, 1.5), {4.375, 2.25, -3.0});
}

TEST(NaturalSpline, OfTwoPointsIsALine) {
  Interpolator spline = Interpolator::natural_spline(make_path(std::array{0.0, 2.0}, {{1.0}, {5.0}}));
  expect_setpoint(evaluate_one(spline, 0.0), {1.0, 2.0, 0.0});
  expect_setpoint(evaluate_one(spline, 1.75), {4.5, 2.0, 0.0});
}

TEST(ClampedSpline, ReproducesACubicOnUnevenKnots) {
  const auto position = [](double t) { return 2.0 * t * t * t - 3.0 * t * t + t - 5.0; };
  const auto velocity = [](double t) { return 6.0 * t * t - 6.0 * t + 1.0; };
  const std::array times_s{-1.0, -0.9, -0.4, 0.3, 0.31, 1.7, 2.0};
  Interpolator spline = Interpolator::clamped_spline(sample_path(times_s, position), std::array{velocity(-1.0)},
                                                     std::array{velocity(2.0)});
  for (int i = 0; i < 300; ++i) {
    const double t = -1.0 + 0.01 * i;
    const AxisSetpoint at = evaluate_one(spline, t);
    EXPECT_NEAR(at.position, position(t), 1e-12) << t;
    EXPECT_NEAR(at.velocity, velocity(t), 1e-12) << t;
    EXPECT_NEAR(at.acceleration, 12.0 * t - 6.0, 1e-11) << t;
  }
}

TEST(ClampedSpline, ConvergesToASineWithTheFourthOrder) {
  const auto largest_error = [](std::size_t segments) {
    std::vector<double> times_s;
    for (std::size_t k = 0; k <= segments; ++k) {
      times_s.push_back(2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(segments));
    }
    Interpolator spline = Interpolator::clamped_spline(sample_path(times_s, [](double t) { return std::sin(t); }),
                                                       std::array{1.0}, std::array{1.0});
    double error = 0.0;
    for (double t = 0.0; t < 2.0 * std::numbers::pi; t += 1e-3) {
      error = std::max(error, std::abs(evaluate_one(spline, t).position - std::sin(t)));
    }
    return error;
  };
  const double coarse = largest_error(20);
  const double medium = largest_error(40);
  const double fine = largest_error(80);
  EXPECT_LT(coarse, 5.0 / 384.0 * std::pow(2.0 * std::numbers::pi / 20.0, 4));  // the known bound 5/384 h^4 |f""|
  EXPECT_NEAR(coarse / medium, 16.0, 1.0);
  EXPECT_NEAR(medium / fine, 16.0, 1.0);
}

TEST(ClampedSpline, RefusesEndVelocitiesThatDoNotFit) {
  const Path path = two_axis_path();
  EXPECT_THROW((void)Interpolator::clamped_spline(path, std::array{1.0}), std::invalid_argument);
  EXPECT_THROW((void)Interpolator::clamped_spline(path, {}, std::array{1.0, 2.0, 3.0}), std::invalid_argument);
  EXPECT_THROW((void)Interpolator::clamped_spline(path, std::array{1.0, kNan}), std::invalid_argument);
  EXPECT_THROW((void)Interpolator::clamped_spline(path, {}, std::array{kInfinity, 0.0}), std::invalid_argument);
}

TEST(Interpolator, StaysFiniteAtTheLimitsOfTheInputDomain) {
  const std::array times_s{0.0, 1e-9, 2e-9, 1e5};
  const Path path = make_path(times_s, {{-1e9}, {1e9}, {-1e9}, {1e9}});
  for (Interpolator spline : {Interpolator::natural_spline(path), Interpolator::clamped_spline(path)}) {
    for (const double t : {0.0, 5e-10, 1.5e-9, 1.0, 5e4, 99999.0}) {
      const AxisSetpoint at = evaluate_one(spline, t);
      EXPECT_TRUE(std::isfinite(at.position) && std::isfinite(at.velocity) && std::isfinite(at.acceleration)) << t;
    }
  }
}

TEST(Interpolator, TheOrderOfTheTimesDoesNotMatter) {
  test::Random random;
  for (int round = 0; round < 20; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Path path = test::random_path(random, 2, 200);
    Interpolator forth = Interpolator::natural_spline(path);
    Interpolator mixed = forth;
    std::vector<double> times_s;
    for (double t = path.start_s() - 0.01; t < path.end_s() + 0.01; t += random.magnitude(1e-5, 0.2)) {
      times_s.push_back(t);
    }
    times_s.insert(times_s.end(), path.times_s().begin(), path.times_s().end());
    std::sort(times_s.begin(), times_s.end());
    std::vector<std::vector<AxisSetpoint>> expected;
    for (const double t : times_s) {
      expected.push_back(evaluate_all(forth, t));
    }
    for (std::size_t i = 0; i < 2 * times_s.size(); ++i) {
      const std::size_t k = random.index(0, times_s.size() - 1);
      const auto actual = evaluate_all(mixed, times_s[k]);
      for (std::size_t axis = 0; axis < actual.size(); ++axis) {
        expect_setpoint(actual[axis], expected[k][axis]);
      }
    }
  }
}

}  // namespace
}  // namespace driveline::trajectory
