// Segment coefficients of cubic splines: velocity and acceleration are continuous at every point.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "b_spline.hpp"
#include "path_columns.hpp"
#include "path_segments.hpp"
#include "segment.hpp"

namespace driveline::trajectory::segment_detail {
namespace {

using Eigen::Index;

/// One equation per knot for the second derivatives, the "moments" of the spline:
///   lower * moment[k-1] + diagonal * moment[k] + upper * moment[k+1] = right
struct Equation {
  double lower = 0.0;
  double diagonal = 1.0;
  double upper = 0.0;
  AxisColumn right;
};

/// Equation for continuous velocity at an inner knot.
Equation inner_equation(const Path& path, std::size_t knot) {
  const double before = step_s(path, knot - 1);
  const double after = step_s(path, knot);
  return {before, 2.0 * (before + after), after, 6.0 * (slope(path, knot) - slope(path, knot - 1))};
}

Equation natural_end(const Path& path) {
  return {0.0, 1.0, 0.0, AxisColumn::Zero(to_index(path.axes().size()))};
}

Equation clamped_start(const Path& path, const AxisColumn& velocity) {
  const double step = step_s(path, 0);
  return {0.0, 2.0 * step, step, 6.0 * (slope(path, 0) - velocity)};
}

Equation clamped_end(const Path& path, const AxisColumn& velocity) {
  const std::size_t last = path.points() - 2;
  const double step = step_s(path, last);
  return {step, 2.0 * step, 0.0, 6.0 * (velocity - slope(path, last))};
}

/// Thomas algorithm. The matrix is the same for all axes and strictly diagonally dominant, so no pivoting is needed;
/// the axes are the rows of the result, the knots its columns.
Eigen::MatrixXd solve_moments(const Path& path, const Equation& start, const Equation& end) {
  const std::size_t knots = path.points();
  Eigen::MatrixXd moments(to_index(path.axes().size()), to_index(knots));
  std::vector<double> upper(knots);
  upper[0] = start.upper / start.diagonal;
  moments.col(0) = start.right / start.diagonal;
  for (std::size_t k = 1; k < knots; ++k) {
    const Equation row = k + 1 < knots ? inner_equation(path, k) : end;
    const double pivot = row.diagonal - row.lower * upper[k - 1];
    upper[k] = row.upper / pivot;
    moments.col(to_index(k)) = (row.right - row.lower * moments.col(to_index(k) - 1)) / pivot;
  }
  for (Index k = to_index(knots) - 2; k >= 0; --k) {
    moments.col(k) -= upper[static_cast<std::size_t>(k)] * moments.col(k + 1);
  }
  return moments;
}

AxisColumn velocity_column(const Path& path, std::span<const double> velocity, const char* which) {
  if (velocity.empty()) {
    return AxisColumn::Zero(to_index(path.axes().size()));
  }
  if (velocity.size() != path.axes().size()) {
    throw std::invalid_argument(std::string("one ") + which + " velocity per axis is needed");
  }
  const auto is_finite = [](double v) { return std::isfinite(v); };
  if (!std::all_of(velocity.begin(), velocity.end(), is_finite)) {
    throw std::invalid_argument(std::string("every ") + which + " velocity must be finite");
  }
  return column(velocity);
}

std::vector<double> segments_of(const Path& path, const Eigen::MatrixXd& moments) {
  const std::size_t axes = path.axes().size();
  std::vector<double> coefficients((path.points() - 1) * 4 * axes);
  for (std::size_t k = 0; k + 1 < path.points(); ++k) {
    fill_moments(&coefficients[k * 4 * axes], axes, step_s(path, k),
                 {path.positions(k).data(), nullptr, moments.col(to_index(k)).data()},
                 {path.positions(k + 1).data(), nullptr, moments.col(to_index(k) + 1).data()});
  }
  return coefficients;
}

/// The control point of an inner point of the path: the straight lines through the points, evaluated at the mean of its
/// knots. For equal steps that is the point itself; for other steps it keeps a straight line straight.
AxisColumn control_point(const Path& path, std::size_t point) {
  const double shift = (step_s(path, point) - step_s(path, point - 1)) / 3.0;
  return column(path.positions(point)) + shift * slope(path, shift > 0.0 ? point : point - 1);
}

/// The curve at the time of a point.
struct CurvePoint {
  AxisColumn position;
  AxisColumn acceleration;
};

/// Control points around point k for the points k - 1, k and k + 1; the first and the last point are repeated.
CurvePoint b_spline_point(const Path& path, std::size_t k) {
  const auto last = to_index(path.points()) - 1;
  const auto nearest = [last](Index point) { return static_cast<std::size_t>(std::clamp<Index>(point, 0, last)); };
  const auto control = [&](Index point) -> AxisColumn {
    if (point <= 0 || point >= last) return column(path.positions(nearest(point)));
    return control_point(path, nearest(point));
  };
  const auto time_s = [&](Index point) { return path.times_s()[nearest(point)]; };
  const Index i = to_index(k);
  const BSplineKnot knot = b_spline_knot({time_s(i - 2), time_s(i - 1), time_s(i), time_s(i + 1), time_s(i + 2)});
  const AxisColumn at = control(i);
  const AxisColumn before = control(i - 1) - at;
  const AxisColumn after = control(i + 1) - at;
  return {at + knot.weight_before * before + knot.weight_after * after,
          knot.acceleration_before * before + knot.acceleration_after * after};
}

}  // namespace

std::vector<double> natural_segments(const Path& path) {
  return segments_of(path, solve_moments(path, natural_end(path), natural_end(path)));
}

std::vector<double> clamped_segments(const Path& path, std::span<const double> start_velocity,
                                     std::span<const double> end_velocity) {
  const Equation start = clamped_start(path, velocity_column(path, start_velocity, "start"));
  const Equation end = clamped_end(path, velocity_column(path, end_velocity, "end"));
  return segments_of(path, solve_moments(path, start, end));
}

std::vector<double> b_spline_segments(const Path& path) {
  const std::size_t axes = path.axes().size();
  std::vector<double> coefficients((path.points() - 1) * 4 * axes);
  CurvePoint here = b_spline_point(path, 0);
  for (std::size_t k = 0; k + 1 < path.points(); ++k) {
    CurvePoint next = b_spline_point(path, k + 1);
    fill_moments(&coefficients[k * 4 * axes], axes, step_s(path, k),
                 {here.position.data(), nullptr, here.acceleration.data()},
                 {next.position.data(), nullptr, next.acceleration.data()});
    here = std::move(next);
  }
  return coefficients;
}

}  // namespace driveline::trajectory::segment_detail
