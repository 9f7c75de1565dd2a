#include "driveline/trajectory/stream_curve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "driveline/trajectory/interpolator.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

class StreamMethods : public testing::TestWithParam<StreamMethod> {};

INSTANTIATE_TEST_SUITE_P(All, StreamMethods,
                         testing::Values(StreamMethod::kHold, StreamMethod::kLinear, StreamMethod::kHermite,
                                         StreamMethod::kCubic, StreamMethod::kQuintic, StreamMethod::kBSpline));

double value_of(std::span<const double> c, double t, int derivative) {
  double sum = 0.0;
  for (std::size_t k = c.size(); k-- > static_cast<std::size_t>(derivative);) {
    double factor = c[k];
    for (int d = 0; d < derivative; ++d) factor *= static_cast<double>(k) - d;
    sum = sum * t + factor;
  }
  return sum;
}

StreamPoint point_of(std::span<const double> c, double t) {
  return {value_of(c, t, 0), value_of(c, t, 1), value_of(c, t, 2)};
}

/// Jittered steps, a factor of 50 between the longest and the shortest.
std::vector<double> jittered(test::Random& random, std::size_t count) {
  std::vector<double> times_s{random.real(-1.0, 1.0)};
  while (times_s.size() < count) times_s.push_back(times_s.back() + random.magnitude(1e-3, 5e-2));
  return times_s;
}

AxisSetpoint at(StreamCurve& curve, double time_s) {
  std::array<AxisSetpoint, 1> out{};
  EXPECT_TRUE(curve.advance(time_s)) << time_s;
  curve.evaluate(time_s, out);
  return out[0];
}

/// Adds setpoints as they are needed and compares from the second of them on.
void expect_reproduced(StreamMethod method, std::span<const double> c, double tolerance) {
  test::Random random;
  const auto times_s = jittered(random, 60);
  StreamCurve curve(method, 1, facts_of(method).delay + 1, 1.0);
  std::size_t added = 0;
  for (std::size_t k = 0; k + 1 + facts_of(method).delay < times_s.size(); ++k) {
    while (added <= k + facts_of(method).delay) {
      curve.add(times_s[added], std::array{point_of(c, times_s[added])});
      ++added;
    }
    for (const double part : {0.0, 0.3, 0.7, 0.99}) {
      const double t = times_s[k] + part * (times_s[k + 1] - times_s[k]);
      const AxisSetpoint now = at(curve, t);
      if (k < 3) continue;  // the curve begins as a straight line
      ASSERT_NEAR(now.position, value_of(c, t, 0), tolerance) << k;
      ASSERT_NEAR(now.velocity, value_of(c, t, 1), 1e3 * tolerance) << k;
      ASSERT_NEAR(now.acceleration, value_of(c, t, 2), 1e7 * tolerance) << k;
    }
  }
}

TEST(StreamCurve, ReproducesPolynomialsOfItsDegreeOnJitteredSteps) {
  expect_reproduced(StreamMethod::kHold, std::array{2.0}, 0.0);
  expect_reproduced(StreamMethod::kLinear, std::array{2.0, -3.0}, 1e-14);
  expect_reproduced(StreamMethod::kBSpline, std::array{2.0, -3.0}, 1e-13);
  expect_reproduced(StreamMethod::kCubic, std::array{2.0, -3.0, 5.0}, 1e-13);
  expect_reproduced(StreamMethod::kHermite, std::array{2.0, -3.0, 5.0, 4.0}, 1e-13);
  expect_reproduced(StreamMethod::kQuintic, std::array{2.0, -3.0, 5.0, 4.0, -1.0, 2.0}, 1e-13);
}

TEST_P(StreamMethods, ReachesAnInstantWithTheStatedDelayAndNotBefore) {
  const std::size_t delay = facts_of(GetParam()).delay;
  StreamCurve curve(GetParam(), 1, 8, 0.01);
  for (std::size_t k = 0; k < delay; ++k) {
    curve.add(0.1 * static_cast<double>(k), std::array{StreamPoint{1.0}});
    EXPECT_FALSE(curve.advance(0.0));
    EXPECT_FALSE(curve.begun());
  }
  curve.add(0.1 * static_cast<double>(delay), std::array{StreamPoint{1.0}});
  EXPECT_FALSE(curve.advance(-1e-6)) << "before the first setpoint";
  EXPECT_TRUE(curve.advance(0.0));
  EXPECT_TRUE(curve.begun());
  const double end_s = delay == 0 ? 0.01 : 0.1;
  EXPECT_TRUE(curve.advance(end_s));
  EXPECT_FALSE(curve.advance(end_s + 1e-9));
  curve.add(0.1 * static_cast<double>(delay + 1), std::array{StreamPoint{1.0}});
  EXPECT_TRUE(curve.advance(0.1 + 1e-9)) << "the next one extends it";
}

TEST_P(StreamMethods, HasRoomForWhatWasAskedFor) {
  StreamCurve curve(GetParam(), 2, 5, 1.0);
  int added = 0;
  const auto fill = [&] {
    for (; !curve.full(); ++added) {
      const double t = 0.1 * added;
      curve.add(t, std::array{StreamPoint{1.0 + t, 1.0}, StreamPoint{2.0 - 3.0 * t, -3.0}});
    }
  };
  fill();
  EXPECT_EQ(added, 6) << "one at the present and five ahead";
  std::array<AxisSetpoint, 2> out{};
  for (double t = 0.005; t < 20.0; t += 0.03) {
    ASSERT_TRUE(curve.advance(t));
    curve.evaluate(t, out);
    const double at = GetParam() == StreamMethod::kHold ? std::floor(t * 10.0) * 0.1 : t;
    ASSERT_NEAR(out[0].position, 1.0 + at, 1e-12) << t;
    ASSERT_NEAR(out[1].position, 2.0 - 3.0 * at, 1e-12) << t;
    fill();
  }
  curve.clear();
  EXPECT_FALSE(curve.begun());
  EXPECT_FALSE(curve.advance(100.0));
}

/// Setpoints before the first one are not lost if many come before the curve starts.
TEST_P(StreamMethods, BeginsTheSameHoweverMuchHasComeBefore) {
  constexpr std::size_t kFew = 5;
  StreamCurve full(GetParam(), 1, kFew, 1.0);
  StreamCurve roomy(GetParam(), 1, 4 * kFew, 1.0);
  for (int k = 0; !full.full(); ++k) {
    const double t = 0.1 * k;
    const std::array points{StreamPoint{t * t * t, 3.0 * t * t, 6.0 * t}};
    full.add(t, points);
    roomy.add(t, points);
  }
  for (double t = 0.001; t < 0.3; t += 0.01) {
    const auto is = at(full, t);
    const auto should = at(roomy, t);
    EXPECT_EQ(is.position, should.position) << t;
    EXPECT_EQ(is.velocity, should.velocity) << t;
  }
}

// Positions within 10 rad, steps from 1 to 50 ms: derivatives up to 1e4 and 1e7.
TEST_P(StreamMethods, AreContinuousAsFarAsClaimedAndNoFurther) {
  const auto claimed = static_cast<int>(facts_of(GetParam()).continuity);
  constexpr std::array kScale{1e1, 1e5, 1e9, 1e13};
  test::Random random;
  const auto times_s = jittered(random, 300);
  StreamCurve curve(GetParam(), 1, times_s.size(), 1.0);
  for (const double t : times_s) {
    curve.add(t, std::array{StreamPoint{random.real(-10.0, 10.0), random.real(-1e3, 1e3), random.real(-1e5, 1e5)}});
  }
  int jumps = 0;
  int knots = 0;
  for (std::size_t k = 1; k + 4 < times_s.size(); ++k) {
    constexpr double kBeside = 1e-8;
    const auto sample = [&](double t) {
      const AxisSetpoint s = at(curve, t);
      return std::array{s.position, s.velocity, s.acceleration};
    };
    const auto before = sample(times_s[k] - kBeside);
    const auto left = sample(std::nextafter(times_s[k], -1e9));
    const auto right = sample(times_s[k]);
    const auto after = sample(times_s[k] + kBeside);
    const std::array<double, 4> jump{right[0] - left[0], right[1] - left[1], right[2] - left[2],
                                     (after[2] - right[2] - (left[2] - before[2])) / kBeside};
    for (int order = 0; order < claimed; ++order) {
      const auto i = static_cast<std::size_t>(order);
      ASSERT_NEAR(jump[i], 0.0, 1e-10 * kScale[i]) << "derivative " << order << " at setpoint " << k;
    }
    const auto next = static_cast<std::size_t>(claimed);
    ++knots;
    jumps += std::abs(jump[next]) > 1e-7 * kScale[next] ? 1 : 0;
  }
  EXPECT_GT(jumps, knots / 2);
}

TEST_P(StreamMethods, GoesOnAlongThePolynomialBeyondTheLastSegment) {
  const std::array c{1.0, 2.0};
  StreamCurve curve(GetParam(), 1, 8, 0.05);
  for (int k = 0; k < 5; ++k) curve.add(0.1 * k, std::array{point_of(c, 0.1 * k)});
  const double end_s = 0.1 * (5.0 - static_cast<double>(facts_of(GetParam()).delay));
  EXPECT_FALSE(curve.advance(end_s + 0.06));
  std::array<AxisSetpoint, 1> out{};
  curve.evaluate(end_s + 0.06, out);
  const bool holds = GetParam() == StreamMethod::kHold;
  EXPECT_NEAR(out[0].position, holds ? 1.8 : 1.0 + 2.0 * (end_s + 0.06), 1e-12);
  EXPECT_NEAR(out[0].velocity, holds ? 0.0 : 2.0, 1e-12);
}

// The same mathematics as for a path, whose ends are elsewhere.
TEST(StreamCurve, AgreesWithThePathFarFromItsEnds) {
  test::Random random;
  const auto times_s = jittered(random, 40);
  std::vector<std::vector<double>> rows;
  for (std::size_t k = 0; k < times_s.size(); ++k) rows.push_back({random.real(-10.0, 10.0)});
  const Path path = test::make_path(times_s, rows);
  const auto expect_same = [&](StreamMethod method, InterpolationMethod same) {
    StreamCurve curve(method, 1, times_s.size(), 1.0);
    for (std::size_t k = 0; k < times_s.size(); ++k) curve.add(times_s[k], std::array{StreamPoint{rows[k][0]}});
    Interpolator interpolator = Interpolator::make(path, same);
    for (double t = times_s[4]; t < times_s[34]; t += 1e-3) {
      const AxisSetpoint now = at(curve, t);
      const AxisSetpoint expected = test::evaluate_one(interpolator, t);
      ASSERT_NEAR(now.position, expected.position, 1e-11);
      ASSERT_NEAR(now.velocity, expected.velocity, 1e-7);
      ASSERT_NEAR(now.acceleration, expected.acceleration, 1e-3);
    }
  };
  expect_same(StreamMethod::kHold, InterpolationMethod::kHold);
  expect_same(StreamMethod::kLinear, InterpolationMethod::kLinear);
  expect_same(StreamMethod::kCubic, InterpolationMethod::kHermite);
  expect_same(StreamMethod::kBSpline, InterpolationMethod::kBSpline);
}

}  // namespace
}  // namespace driveline::trajectory
