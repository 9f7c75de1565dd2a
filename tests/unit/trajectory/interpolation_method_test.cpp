// Guarantees of every method, on difficult paths: uneven steps, two points, 128 axes.
#include "driveline/trajectory/interpolation_method.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/path_clock.hpp"
#include "driveline/trajectory/start_ramp.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

using Method = InterpolationMethod;

class InterpolationMethods : public testing::TestWithParam<Method> {};

INSTANTIATE_TEST_SUITE_P(All, InterpolationMethods,
                         testing::Values(Method::kHold, Method::kLinear, Method::kHermite, Method::kNaturalSpline,
                                         Method::kClampedSpline, Method::kQuintic, Method::kCosine, Method::kBSpline),
                         [](const auto& tested) { return std::string(facts_of(tested.param).name); });

/// Position, velocity, acceleration and jerk of axis 0 on both sides of a knot.
struct Sides {
  std::array<double, 4> left;
  std::array<double, 4> right;
};

std::array<double, 4> derivatives_at(Interpolator& curve, double time_s, double towards_s) {
  const AxisSetpoint at = test::evaluate_one(curve, time_s);
  const AxisSetpoint beside = test::evaluate_one(curve, towards_s);
  return {at.position, at.velocity, at.acceleration, (beside.acceleration - at.acceleration) / (towards_s - time_s)};
}

Sides sides_of(Interpolator& curve, double knot, double distance) {
  return {derivatives_at(curve, std::nextafter(knot, -1e9), knot - distance),
          derivatives_at(curve, knot, knot + distance)};
}

// Steps from 5 to 50 ms and positions within 10 rad: derivatives are of the order of 1e1, 1e4, 1e7, 1e10.
TEST_P(InterpolationMethods, AreContinuousAsFarAsClaimedAndNoFurther) {
  const auto claimed = static_cast<int>(facts_of(GetParam()).continuity);
  constexpr std::array kScale{1e1, 1e4, 1e7, 1e10};
  test::Random random;
  int jumps = 0;
  int knots = 0;
  for (int round = 0; round < 40; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Path path = test::random_path(random, 3, 40);
    Interpolator curve = Interpolator::make(path, GetParam());
    for (std::size_t k = 1; k + 1 < path.points(); ++k) {
      const Sides at = sides_of(curve, path.times_s()[k], 1e-8);
      for (int order = 0; order < claimed; ++order) {
        const auto i = static_cast<std::size_t>(order);
        ASSERT_NEAR(at.left[i], at.right[i], 1e-9 * kScale[i]) << "derivative " << order << " at point " << k;
      }
      const auto next = static_cast<std::size_t>(claimed);
      ++knots;
      jumps += std::abs(at.left[next] - at.right[next]) > 1e-4 * kScale[next] ? 1 : 0;
    }
  }
  EXPECT_GT(jumps, knots / 2) << "the next derivative is not continuous, or more could be claimed";
}

TEST_P(InterpolationMethods, MeetTheirPointsOrSayThatTheyDoNot) {
  test::Random random;
  double farthest = 0.0;
  for (int round = 0; round < 40; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Path path = test::random_path(random, 2, 60);
    Interpolator curve = Interpolator::make(path, GetParam());
    for (const std::size_t end : {std::size_t{0}, path.points() - 1}) {
      ASSERT_EQ(test::evaluate_one(curve, path.times_s()[end]).position, path.positions(end)[0]);
    }
    for (std::size_t k = 0; k < path.points(); ++k) {
      const double off = test::evaluate_one(curve, path.times_s()[k]).position - path.positions(k)[0];
      farthest = std::max(farthest, std::abs(off));
    }
  }
  if (facts_of(GetParam()).meets_points) {
    EXPECT_EQ(farthest, 0.0);
  } else {
    EXPECT_GT(farthest, 1.0);
  }
}

TEST_P(InterpolationMethods, ReportTheDerivativesOfTheirPositions) {
  test::Random random;
  for (int round = 0; round < 40; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Path path = test::random_path(random, 2, 30);
    Interpolator curve = Interpolator::make(path, GetParam());
    for (std::size_t k = 0; k + 1 < path.points(); ++k) {
      const double step = path.times_s()[k + 1] - path.times_s()[k];
      const double t = path.times_s()[k] + random.real(0.1, 0.9) * step;
      const double h = 1e-3 * step;
      const auto before = test::evaluate_all(curve, t - h);
      const auto at = test::evaluate_all(curve, t);
      const auto after = test::evaluate_all(curve, t + h);
      for (std::size_t i = 0; i < at.size(); ++i) {
        ASSERT_NEAR(at[i].velocity, (after[i].position - before[i].position) / (2.0 * h), 1e-4 * 10.0 / step);
        ASSERT_NEAR(at[i].acceleration, (after[i].velocity - before[i].velocity) / (2.0 * h),
                    1e-3 * 100.0 / (step * step));
      }
    }
  }
}

TEST_P(InterpolationMethods, BeginAndEndAtRestUnlessTheirNatureForbidsIt) {
  const bool at_rest = GetParam() != Method::kLinear && GetParam() != Method::kNaturalSpline;
  test::Random random;
  for (int round = 0; round < 40; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Path path = test::random_path(random, 2, 40);
    Interpolator curve = Interpolator::make(path, GetParam());
    for (const double time_s : {path.start_s(), std::nextafter(path.end_s(), -1e9)}) {
      const AxisSetpoint end = test::evaluate_one(curve, time_s);
      if (at_rest) {
        ASSERT_NEAR(end.velocity, 0.0, 1e-6);
      } else {
        ASSERT_GT(std::abs(end.velocity), 1e-6);
      }
      if (GetParam() == Method::kQuintic) {
        ASSERT_NEAR(end.acceleration, 0.0, 1e-3);
      }
    }
  }
}

TEST_P(InterpolationMethods, HoldStillWhereAllPointsAreTheSame) {
  test::Random random;
  const double where = random.real(-1e6, 1e6);
  const std::array times_s{0.0, 1e-6, 0.5, 0.6, 3.0, 1e3};
  Interpolator curve = Interpolator::make(test::sample_path(times_s, [&](double) { return where; }), GetParam());
  for (double t = 0.0; t < 4.0; t += 0.01) {
    test::expect_setpoint(test::evaluate_one(curve, t), {where, 0.0, 0.0});
  }
}

TEST_P(InterpolationMethods, TreatEachOf128AxesAsIfItWereAlone) {
  test::Random random;
  std::vector<double> times_s{0.0};
  for (int k = 0; k < 12; ++k) times_s.push_back(times_s.back() + random.magnitude(1e-3, 1.0));
  std::vector<std::vector<double>> rows(times_s.size(), std::vector<double>(128));
  for (auto& row : rows) {
    for (double& position : row) position = random.magnitude(1e-6, 1e6) * random.real(-1.0, 1.0);
  }
  Interpolator all = Interpolator::make(test::make_path(times_s, rows), GetParam());
  for (std::size_t axis = 0; axis < 128; ++axis) {
    std::vector<std::vector<double>> own;
    for (const auto& row : rows) own.push_back({row[axis]});
    Interpolator one = Interpolator::make(test::make_path(times_s, own), GetParam());
    for (int sample = 0; sample < 50; ++sample) {
      const double t = times_s.back() * sample / 49.0;
      test::expect_setpoint(test::evaluate_all(all, t)[axis], test::evaluate_one(one, t));
    }
  }
}

TEST_P(InterpolationMethods, StayFiniteAtTheLimitsOfTheInputDomain) {
  const std::array times_s{-1e5, -1e5 + 1e-9 * 15, 0.0, 1e-9, 2e-9, 4e-9, 1e5};
  const Path path = test::make_path(times_s, {{-1e9}, {1e9}, {-1e9}, {1e9}, {-1e9}, {1e9}, {-1e9}});
  Interpolator curve = Interpolator::make(path, GetParam());
  for (std::size_t k = 0; k + 1 < times_s.size(); ++k) {
    for (const double part : {0.0, 0.3, 0.5, 0.999}) {
      const AxisSetpoint at = test::evaluate_one(curve, times_s[k] + part * (times_s[k + 1] - times_s[k]));
      EXPECT_TRUE(std::isfinite(at.position) && std::isfinite(at.velocity) && std::isfinite(at.acceleration)) << k;
    }
  }
}

TEST_P(InterpolationMethods, CanBeBroughtToRestWithinTheLimitsThatTheyPassed) {
  std::vector<double> times_s;
  for (int k = 0; k <= 100; ++k) times_s.push_back(k * 0.01);
  const Path path =
      test::sample_path(times_s, [](double t) { return 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * t)); });
  Interpolator curve = Interpolator::make(path, GetParam());
  const std::array limits{AxisLimits{1e4, 1e9}};
  ASSERT_TRUE(check_limits(curve, limits, 125e-6).has_value());
  const double ramp_s = path_ramp_s(curve, limits);
  EXPECT_GE(ramp_s, 1e-3);
  const double rate = path_catch_up_rate(curve, limits, ramp_s);
  const bool jumps = facts_of(GetParam()).continuity <= Continuity::kPosition;
  EXPECT_EQ(rate, jumps ? 1.0 : 1.25);
}

// Half way between two points the error of such a curve is a power of the step.
TEST_P(InterpolationMethods, ConvergeToASmoothMotionWithTheirOrder) {
  const auto motion = [](double t) { return std::pow(std::sin(t), 6); };  // at rest at both ends, to the fifth degree
  const auto largest_error = [&](std::size_t segments) {
    std::vector<double> times_s;
    for (std::size_t k = 0; k <= segments; ++k) {
      times_s.push_back(std::numbers::pi * static_cast<double>(k) / static_cast<double>(segments));
    }
    Interpolator curve = Interpolator::make(test::sample_path(times_s, motion), GetParam());
    double error = 0.0;
    for (int i = 0; i < 5000; ++i) {
      const double t = std::numbers::pi * i / 5000.0;
      error = std::max(error, std::abs(test::evaluate_one(curve, t).position - motion(t)));
    }
    return error;
  };
  constexpr std::array<double, 8> kOrders{1.0, 2.0, 3.0, 4.0, 4.0, 5.0, 1.0, 2.0};
  const double order = std::log2(largest_error(100) / largest_error(200));
  EXPECT_NEAR(order, kOrders[static_cast<std::size_t>(GetParam())], GetParam() == Method::kQuintic ? 1.1 : 0.15);
}

double polynomial(std::span<const double> c, double t, int derivative) {
  double sum = 0.0;
  for (std::size_t k = c.size(); k-- > static_cast<std::size_t>(derivative);) {
    double factor = c[k];
    for (int d = 0; d < derivative; ++d) factor *= static_cast<double>(k) - d;
    sum = sum * t + factor;
  }
  return sum;
}

/// The points of a polynomial on very uneven steps, with its derivatives.
Path polynomial_path(std::span<const double> c, bool with_velocity, bool with_acceleration) {
  constexpr std::array kTimes{-1.0, -0.9, -0.4, 0.3, 0.301, 1.7, 2.0, 2.5};
  PathBuilder builder;
  test::require(builder.add_axis({"a", AxisKind::kRotary, nullptr, with_velocity, with_acceleration}));
  for (const double t : kTimes) {
    test::require(builder.add_point(
        {t, std::array{polynomial(c, t, 0)}, std::array{polynomial(c, t, 1)}, std::array{polynomial(c, t, 2)}}));
  }
  return builder.build().value();
}

void expect_polynomial(Interpolator curve, std::span<const double> c, double from_s, double to_s, double tolerance) {
  for (int i = 0; i < 300; ++i) {
    const double t = from_s + (to_s - from_s) * i / 300.0;
    const AxisSetpoint at = test::evaluate_one(curve, t);
    ASSERT_NEAR(at.position, polynomial(c, t, 0), tolerance) << t;
    ASSERT_NEAR(at.velocity, polynomial(c, t, 1), 10.0 * tolerance) << t;
    ASSERT_NEAR(at.acceleration, polynomial(c, t, 2), 1e3 * tolerance) << t;
  }
}

TEST(HermiteInterpolator, WithVelocitiesReproducesACubicToBothEnds) {
  const std::array c{-5.0, 1.0, -3.0, 2.0};
  expect_polynomial(Interpolator::hermite(polynomial_path(c, true, false)), c, -1.0, 2.5, 1e-12);
}

TEST(HermiteInterpolator, WithoutThemReproducesAParabolaInside) {
  const std::array c{-5.0, 1.0, -3.0};
  expect_polynomial(Interpolator::hermite(polynomial_path(c, false, false)), c, -0.9, 2.0, 1e-12);
}

TEST(HermiteInterpolator, VelocitiesAreThoseOfTheirAxis) {
  PathBuilder builder;
  test::require(builder.add_axis({"a", AxisKind::kRotary}));
  test::require(builder.add_axis({"b", AxisKind::kRotary, nullptr, true}));
  const std::array zero{0.0, 0.0};
  test::require(builder.add_point({0.0, zero, std::array{7.0, 1.0}, {}}));
  test::require(builder.add_point({1.0, zero, std::array{7.0, -2.0}, {}}));
  Interpolator curve = Interpolator::hermite(builder.build().value());
  test::expect_setpoint(test::evaluate_all(curve, 0.5)[0], {0.0, 0.0, 0.0});
  test::expect_setpoint(test::evaluate_all(curve, 0.5)[1], {0.375, -0.25 + 0.5, -3.0});
}

TEST(QuinticInterpolator, WithDerivativesReproducesTheFifthDegreeToBothEnds) {
  const std::array c{-5.0, 1.0, -3.0, 2.0, 0.5, -0.75};
  expect_polynomial(Interpolator::quintic(polynomial_path(c, true, true)), c, -1.0, 2.5, 1e-10);
}

TEST(QuinticInterpolator, WithoutThemReproducesTheFourthDegreeInside) {
  const std::array c{-5.0, 1.0, -3.0, 2.0, 0.5};
  expect_polynomial(Interpolator::quintic(polynomial_path(c, false, false)), c, -0.9, 2.0, 1e-9);
}

TEST(QuinticInterpolator, OfTwoPointsIsTheWayOfLeastJerk) {
  Interpolator curve = Interpolator::quintic(test::make_path(std::array{0.0, 2.0}, {{1.0}, {5.0}}));
  auto ramp = StartRamp::plan(1.0, 5.0, {1e9, 1e9});
  ASSERT_TRUE(ramp.has_value());
  ramp->stretch_to(2.0);
  for (int i = 0; i < 200; ++i) {
    const AxisSetpoint at = test::evaluate_one(curve, 0.01 * i);
    const AxisSetpoint expected = ramp->evaluate(0.01 * i);
    EXPECT_NEAR(at.position, expected.position, 1e-13);
    EXPECT_NEAR(at.velocity, expected.velocity, 1e-13);
    EXPECT_NEAR(at.acceleration, expected.acceleration, 1e-12);
  }
}

TEST(CosineInterpolator, GoesFromPointToPointInHalfAPeriod) {
  Interpolator curve = Interpolator::cosine(test::make_path(std::array{0.0, 2.0, 2.5}, {{1.0}, {5.0}, {4.0}}));
  const double w = std::numbers::pi / 2.0;
  const auto expect_near = [&](double t, const AxisSetpoint& expected) {
    const AxisSetpoint at = test::evaluate_one(curve, t);
    EXPECT_NEAR(at.position, expected.position, 1e-14) << t;
    EXPECT_NEAR(at.velocity, expected.velocity, 1e-13) << t;
    EXPECT_NEAR(at.acceleration, expected.acceleration, 1e-13) << t;
  };
  expect_near(0.0, {1.0, 0.0, 2.0 * w * w});
  expect_near(1.0, {3.0, 2.0 * w, 0.0});
  expect_near(0.5, {3.0 - std::numbers::sqrt2, w * std::numbers::sqrt2, w * w * std::numbers::sqrt2});
  expect_near(2.25, {4.5, -std::numbers::pi, 0.0});
}

TEST(HoldInterpolator, JumpsAtThePoints) {
  Interpolator curve = Interpolator::hold(test::make_path(std::array{0.0, 1.0, 4.0}, {{1.0}, {5.0}, {-2.0}}));
  test::expect_setpoint(test::evaluate_one(curve, std::nextafter(1.0, 0.0)), {1.0, 0.0, 0.0});
  test::expect_setpoint(test::evaluate_one(curve, 1.0), {5.0, 0.0, 0.0});
  test::expect_setpoint(test::evaluate_one(curve, std::nextafter(4.0, 0.0)), {5.0, 0.0, 0.0});
  test::expect_setpoint(test::evaluate_one(curve, 4.0), {-2.0, 0.0, 0.0});
}

TEST(HoldInterpolator, JumpsAreRefusedByEitherLimitAndSmallOnesArePassed) {
  const Path path = test::make_path(std::array{0.0, 1.0, 2.0}, {{1.0}, {1.0}, {1.5}});
  const auto verdict = [&](AxisLimits limits) {
    Interpolator curve = Interpolator::hold(path);
    const auto checked = check_limits(curve, std::array{limits}, 1.0 / 1024.0);
    return checked ? "accepted" : checked.error().message();
  };
  EXPECT_EQ(verdict({512.0, 512.0 * 1024.0}), "accepted");
  EXPECT_EQ(verdict({500.0, 1e9}),
            "axis 'a0' would jump from point to point and need a velocity of 512 rad/s at 2 s; its limit is 500 rad/s");
  EXPECT_EQ(verdict({512.0, 1e3}),
            "axis 'a0' would jump from point to point and need an acceleration of 524288 rad/s^2 at 2 s; its limit is "
            "1000 rad/s^2");
}

TEST(BSplineInterpolator, OnEvenStepsIsTheUniformOne) {
  test::Random random;
  std::vector<double> times_s;
  std::vector<std::vector<double>> rows;
  for (int k = 0; k < 20; ++k) {
    times_s.push_back(0.25 * k);
    rows.push_back({random.real(-10.0, 10.0)});
  }
  Interpolator curve = Interpolator::b_spline(test::make_path(times_s, rows));
  const auto p = [&](std::size_t k) { return rows[k][0]; };
  for (std::size_t k = 2; k + 2 < rows.size(); ++k) {
    const AxisSetpoint at = test::evaluate_one(curve, times_s[k]);
    EXPECT_NEAR(at.position, (p(k - 1) + 4.0 * p(k) + p(k + 1)) / 6.0, 1e-13);
    EXPECT_NEAR(at.velocity, (p(k + 1) - p(k - 1)) / 0.5, 1e-12);
    EXPECT_NEAR(at.acceleration, (p(k + 1) - 2.0 * p(k) + p(k - 1)) / 0.0625, 1e-11);
  }
}

TEST(BSplineInterpolator, KeepsAnEvenMotionEvenOnUnevenSteps) {
  const std::array c{3.0, -2.0};
  expect_polynomial(Interpolator::b_spline(polynomial_path(c, false, false)), c, -0.4, 1.7, 1e-12);
}

TEST(BSplineInterpolator, NeverLeavesTheRangeOfThePointsAround) {
  test::Random random;
  for (int round = 0; round < 200; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    std::vector<double> times_s{0.0};
    std::vector<std::vector<double>> rows{{random.real(-10.0, 10.0)}};
    for (std::size_t k = random.index(1, 12); k > 0; --k) {
      times_s.push_back(times_s.back() + random.magnitude(1e-6, 10.0));
      rows.push_back({random.real(-10.0, 10.0)});
    }
    Interpolator curve = Interpolator::b_spline(test::make_path(times_s, rows));
    for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
      double low = rows[k][0];
      double high = low;
      for (std::size_t i = std::max<std::size_t>(k, 2) - 2; i < std::min(k + 4, rows.size()); ++i) {
        low = std::min(low, rows[i][0]);
        high = std::max(high, rows[i][0]);
      }
      for (int part = 0; part < 20; ++part) {
        const double at = test::evaluate_one(curve, times_s[k] + (times_s[k + 1] - times_s[k]) * part / 20.0).position;
        ASSERT_GE(at, low - 1e-12);
        ASSERT_LE(at, high + 1e-12);
      }
    }
  }
}

TEST(InterpolationMethod, IsFoundByItsWholeName) {
  for (const auto* const name : {"", "Linear", "linea", "linear ", "spline"}) {
    EXPECT_EQ(find_interpolation_method(name), nullptr) << name;
  }
}

TEST(InterpolationMethod, HasOneNameEachInTheOrderOfTheEnumeration) {
  const auto methods = interpolation_methods();
  ASSERT_EQ(methods.size(), 8U);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(methods[i].method), i);
    EXPECT_EQ(&facts_of(methods[i].method), &methods[i]);
    EXPECT_EQ(find_interpolation_method(methods[i].name), &methods[i]);
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(methods[i].name, methods[k].name);
    const std::array times_s{0.0, 1.0};
    const auto curve = Interpolator::make(test::make_path(times_s, {{0.0}, {1.0}}), methods[i].method);
    EXPECT_EQ(curve.method(), methods[i].method);
  }
}

}  // namespace
}  // namespace driveline::trajectory
