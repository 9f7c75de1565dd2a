// The defining properties of cubic splines, checked on random paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::evaluate_all;

struct Case {
  const Path& path;
  Interpolator spline;
  std::vector<double> start_velocity;
  std::vector<double> end_velocity;
  bool is_natural;
};

void for_random_splines(const std::function<void(Case&)>& check) {
  test::Random random;
  for (int round = 0; round < 60; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Path path = test::random_path(random, 2, 120);
    std::vector<double> start(path.axes().size());
    std::vector<double> end(path.axes().size());
    for (std::size_t i = 0; i < start.size(); ++i) {
      start[i] = random.real(-300.0, 300.0);
      end[i] = random.real(-300.0, 300.0);
    }
    Case natural{path, Interpolator::natural_spline(path), {}, {}, true};
    check(natural);
    Case clamped{path, Interpolator::clamped_spline(path, start, end), start, end, false};
    check(clamped);
    if (testing::Test::HasFailure()) {
      return;
    }
  }
}

/// The largest acceleration of an axis at its knots, and so everywhere: it is linear in between.
double largest_acceleration(Case& c, std::size_t axis) {
  double largest = 0.0;
  for (const double knot : c.path.times_s()) {
    largest = std::max(largest, std::abs(evaluate_all(c.spline, knot)[axis].acceleration));
    largest = std::max(largest, std::abs(evaluate_all(c.spline, std::nextafter(knot, -1e9))[axis].acceleration));
  }
  return largest;
}

TEST(SplineProperty, PassesThroughThePoints) {
  for_random_splines([](Case& c) {
    for (std::size_t k = 0; k < c.path.points(); ++k) {
      const double knot = c.path.times_s()[k];
      const auto at = evaluate_all(c.spline, knot);
      for (std::size_t i = 0; i < at.size(); ++i) {
        EXPECT_EQ(at[i].position, c.path.positions(k)[i]);
      }
    }
  });
}

// Coming from the left the cubic of the segment must arrive where the next one begins. nextafter() moves by up to
// 1 ulp(5 s) ~ 1e-15 s, which the tolerances include: 1e-15 s times the derivative.
TEST(SplineProperty, IsContinuousToTheSecondDerivative) {
  for_random_splines([](Case& c) {
    for (std::size_t i = 0; i < c.path.axes().size(); ++i) {
      const double scale = largest_acceleration(c, i);  // steps are at most 50 ms
      for (std::size_t k = 1; k + 1 < c.path.points(); ++k) {
        const double knot = c.path.times_s()[k];
        const AxisSetpoint left = evaluate_all(c.spline, std::nextafter(knot, -1e9))[i];
        const AxisSetpoint right = evaluate_all(c.spline, knot)[i];
        EXPECT_NEAR(left.position, right.position, 1e-12 * std::max(10.0, 0.05 * 0.05 * scale));
        EXPECT_NEAR(left.velocity, right.velocity, 1e-12 * 0.05 * scale);
        EXPECT_NEAR(left.acceleration, right.acceleration, 1e-11 * scale);
      }
    }
  });
}

TEST(SplineProperty, MeetsItsEndConditions) {
  for_random_splines([](Case& c) {
    const auto start = evaluate_all(c.spline, c.path.start_s());
    const auto end = evaluate_all(c.spline, std::nextafter(c.path.end_s(), -1e9));
    for (std::size_t i = 0; i < start.size(); ++i) {
      const double scale = largest_acceleration(c, i);
      if (c.is_natural) {
        EXPECT_EQ(start[i].acceleration, 0.0);
        EXPECT_NEAR(end[i].acceleration, 0.0, 1e-11 * scale);
      } else {
        EXPECT_NEAR(start[i].velocity, c.start_velocity[i], 1e-12 * scale);
        EXPECT_NEAR(end[i].velocity, c.end_velocity[i], 1e-12 * scale);
      }
      EXPECT_NEAR(end[i].position, c.path.positions(c.path.points() - 1)[i],
                  1e-12 * std::max(10.0, 0.05 * 0.05 * scale));
    }
  });
}

// The five-point formulas are exact for cubics, so only rounding is left: that of the positions and that of the times
// (up to 10 s), which the velocity turns into positions.
TEST(SplineProperty, ReportsTheDerivativesOfItsPositions) {
  for_random_splines([](Case& c) {
    for (std::size_t k = 0; k + 1 < c.path.points(); ++k) {
      const double step = c.path.times_s()[k + 1] - c.path.times_s()[k];
      const double middle = c.path.times_s()[k] + 0.5 * step;
      const double h = step / 8.0;
      const auto p = [&](double t, std::size_t i) { return evaluate_all(c.spline, t)[i].position; };
      const auto at = evaluate_all(c.spline, middle);
      for (std::size_t i = 0; i < at.size(); ++i) {
        const double m2 = p(middle - 2.0 * h, i);
        const double m1 = p(middle - h, i);
        const double p1 = p(middle + h, i);
        const double p2 = p(middle + 2.0 * h, i);
        const double size = std::max({std::abs(m2), std::abs(m1), std::abs(p1), std::abs(p2)});
        const double noise = 1e-15 * (size + 10.0 * std::abs(at[i].velocity) + 10.0 * h * std::abs(at[i].acceleration));
        const double velocity = (m2 - 8.0 * m1 + 8.0 * p1 - p2) / (12.0 * h);
        const double acceleration = (-m2 + 16.0 * m1 - 30.0 * at[i].position + 16.0 * p1 - p2) / (12.0 * h * h);
        EXPECT_NEAR(at[i].velocity, velocity, 3.0 * noise / h);
        EXPECT_NEAR(at[i].acceleration, acceleration, 10.0 * noise / (h * h));
      }
    }
  });
}

}  // namespace
}  // namespace driveline::trajectory
