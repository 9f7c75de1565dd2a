// Compares the splines with two oracles that are independent of the implementation: exact rational arithmetic in
// Python, and a dense solve for the power coefficients.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

struct Reference {
  double time_s;
  double position;
  double velocity;
  double acceleration;
};

#include "spline_reference.inc"

// The same numbers as in make_spline_reference.py; all are exact in binary.
Path reference_path() {
  return test::make_path(std::array{0.0, 0.5, 0.75, 2.0, 2.25, 4.0, 4.0 + 1.0 / 1024.0},
                         {{1.0}, {-2.0}, {1.25}, {0.5}, {8.0}, {-3.0}, {-3.0 + 1.0 / 512.0}});
}

void expect_reference(Interpolator interpolator, std::span<const Reference> references) {
  for (const Reference& expected : references) {
    const AxisSetpoint actual = test::evaluate_one(interpolator, expected.time_s);
    EXPECT_NEAR(actual.position, expected.position, 1e-13 * 10.0) << expected.time_s;
    EXPECT_NEAR(actual.velocity, expected.velocity, 1e-13 * 100.0) << expected.time_s;
    EXPECT_NEAR(actual.acceleration, expected.acceleration, 1e-12 * 5000.0) << expected.time_s;
  }
}

TEST(SplineReference, NaturalSplineAgreesWithExactArithmetic) {
  expect_reference(Interpolator::natural_spline(reference_path()), kNaturalReference);
}

TEST(SplineReference, ClampedSplineAgreesWithExactArithmetic) {
  expect_reference(Interpolator::clamped_spline(reference_path(), std::array{1.5}, std::array{-0.25}),
                   kClampedReference);
}

TEST(SplineReference, BSplineAgreesWithExactArithmetic) {
  expect_reference(Interpolator::b_spline(reference_path()), kBSplineReference);
}

TEST(SplineReference, HermiteAgreesWithExactArithmetic) {
  expect_reference(Interpolator::hermite(reference_path()), kHermiteReference);
}

TEST(SplineReference, QuinticAgreesWithExactArithmetic) {
  expect_reference(Interpolator::quintic(reference_path()), kQuinticReference);
}

enum class Ends { kNatural, kClamped };

/// Power coefficients (time since the segment's start, ascending) of the spline of an axis, from a dense system with
/// four unknowns per segment.
Eigen::VectorXd dense_spline(const Path& path, std::size_t axis, Ends ends, double start_velocity,
                             double end_velocity) {
  using Eigen::Index;
  const Index segments = static_cast<Index>(path.points()) - 1;
  const auto step = [&](Index k) {
    const auto i = static_cast<std::size_t>(k);
    return path.times_s()[i + 1] - path.times_s()[i];
  };
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(4 * segments, 4 * segments);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(4 * segments);
  Index row = 0;
  const auto powers = [](double t, int derivative) -> Eigen::RowVector4d {
    return derivative == 0   ? Eigen::RowVector4d(1.0, t, t * t, t * t * t)
           : derivative == 1 ? Eigen::RowVector4d(0.0, 1.0, 2.0 * t, 3.0 * t * t)
                             : Eigen::RowVector4d(0.0, 0.0, 2.0, 6.0 * t);
  };
  for (Index k = 0; k < segments; ++k) {
    const auto i = static_cast<std::size_t>(k);
    matrix.block<1, 4>(row, 4 * k) = powers(0.0, 0);
    right(row++) = path.positions(i)[axis];
    matrix.block<1, 4>(row, 4 * k) = powers(step(k), 0);
    right(row++) = path.positions(i + 1)[axis];
    for (int derivative = 1; derivative <= 2 && k + 1 < segments; ++derivative) {
      matrix.block<1, 4>(row, 4 * k) = powers(step(k), derivative);
      matrix.block<1, 4>(row++, 4 * k + 4) = -powers(0.0, derivative);
    }
  }
  const int derivative = ends == Ends::kNatural ? 2 : 1;
  matrix.block<1, 4>(row, 0) = powers(0.0, derivative);
  right(row++) = ends == Ends::kNatural ? 0.0 : start_velocity;
  matrix.block<1, 4>(row, 4 * segments - 4) = powers(step(segments - 1), derivative);
  right(row++) = ends == Ends::kNatural ? 0.0 : end_velocity;
  return matrix.fullPivLu().solve(right);
}

void expect_dense(Interpolator interpolator, const Path& path, std::size_t axis, const Eigen::VectorXd& coefficients) {
  for (std::size_t k = 0; k + 1 < path.points(); ++k) {
    const Eigen::Vector4d c = coefficients.segment<4>(4 * static_cast<Eigen::Index>(k));
    for (const double part : {0.0, 0.25, 0.5, 0.9}) {
      const double t = part * (path.times_s()[k + 1] - path.times_s()[k]);
      const AxisSetpoint at = test::evaluate_all(interpolator, path.times_s()[k] + t)[axis];
      // Positions reach 10, steps 5 ms: velocities are of the order of 1e4, accelerations of 1e7.
      EXPECT_NEAR(at.position, c(0) + t * (c(1) + t * (c(2) + t * c(3))), 1e-9);
      EXPECT_NEAR(at.velocity, c(1) + t * (2.0 * c(2) + 3.0 * t * c(3)), 1e-6);
      EXPECT_NEAR(at.acceleration, 2.0 * c(2) + 6.0 * t * c(3), 1e-3);
    }
  }
}

TEST(SplineReference, RandomSplinesAgreeWithADenseSolve) {
  test::Random random;
  for (int round = 0; round < 40; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Path path = test::random_path(random, 2, 14);
    const std::size_t axes = path.axes().size();
    std::vector<double> start(axes);
    std::vector<double> end(axes);
    for (std::size_t i = 0; i < axes; ++i) {
      start[i] = random.real(-500.0, 500.0);
      end[i] = random.real(-500.0, 500.0);
    }
    const std::size_t axis = random.index(0, axes - 1);
    expect_dense(Interpolator::natural_spline(path), path, axis, dense_spline(path, axis, Ends::kNatural, 0.0, 0.0));
    expect_dense(Interpolator::clamped_spline(path, start, end), path, axis,
                 dense_spline(path, axis, Ends::kClamped, start[axis], end[axis]));
  }
}

}  // namespace
}  // namespace driveline::trajectory
