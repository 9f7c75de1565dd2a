#include "driveline/trajectory/interpolator.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace driveline::trajectory {
namespace {

using Eigen::Index;
using AxisColumn = Eigen::VectorXd;

/// Four columns, one per power of the time since the segment's start; one row per axis.
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 4>;

Index to_index(std::size_t value) {
  return static_cast<Index>(value);
}

Eigen::Map<const AxisColumn> column(std::span<const double> values) {
  return {values.data(), to_index(values.size())};
}

double step_s(const Path& path, std::size_t segment) {
  return path.times_s()[segment + 1] - path.times_s()[segment];
}

AxisColumn slope(const Path& path, std::size_t segment) {
  return (column(path.positions(segment + 1)) - column(path.positions(segment))) / step_s(path, segment);
}

/// One equation per knot for the second derivatives there, the "moments" of the spline:
///   lower * moment[k-1] + diagonal * moment[k] + upper * moment[k+1] = right
struct Equation {
  double lower = 0.0;
  double diagonal = 1.0;
  double upper = 0.0;
  AxisColumn right;
};

/// The velocity is continuous at an inner knot.
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

/// Thomas algorithm. The matrix is the same for all axes and strictly diagonally dominant, so that no pivoting is
/// needed; the axes are the rows of the result, the knots its columns.
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

void fill_segment(Eigen::Map<Coefficients> segment, const Path& path, std::size_t k, const AxisColumn& here,
                  const AxisColumn& next) {
  const double step = step_s(path, k);
  segment.col(0) = column(path.positions(k));
  segment.col(1) = slope(path, k) - (step / 6.0) * (2.0 * here + next);
  segment.col(2) = here / 2.0;
  segment.col(3) = (next - here) / (6.0 * step);
}

std::span<const double> values(const Eigen::MatrixXd& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}

}  // namespace

Interpolator::Interpolator(const Path& path, std::span<const double> moments)
    : axes_(path.axes()),
      knots_s_(path.times_s().begin(), path.times_s().end()),
      coefficients_((path.points() - 1) * 4 * axes_.size()),
      end_positions_(path.positions(path.points() - 1).begin(), path.positions(path.points() - 1).end()),
      previous_s_(path.start_s()) {
  const std::size_t axes = axes_.size();
  for (std::size_t k = 0; k + 1 < path.points(); ++k) {
    fill_segment({&coefficients_[k * 4 * axes], to_index(axes), 4}, path, k, column(moments.subspan(k * axes, axes)),
                 column(moments.subspan((k + 1) * axes, axes)));
  }
}

Interpolator Interpolator::linear(const Path& path) {
  return {path, std::vector<double>(path.points() * path.axes().size(), 0.0)};
}

Interpolator Interpolator::natural_spline(const Path& path) {
  return {path, values(solve_moments(path, natural_end(path), natural_end(path)))};
}

Interpolator Interpolator::clamped_spline(const Path& path, std::span<const double> start_velocity,
                                          std::span<const double> end_velocity) {
  const Equation start = clamped_start(path, velocity_column(path, start_velocity, "start"));
  const Equation end = clamped_end(path, velocity_column(path, end_velocity, "end"));
  return {path, values(solve_moments(path, start, end))};
}

void Interpolator::locate(double time_s) noexcept {
  constexpr int kCursorSteps = 2;
  if (time_s >= knots_s_[cursor_]) {
    for (int step = 0; step < kCursorSteps && time_s >= knots_s_[cursor_ + 1]; ++step) {
      ++cursor_;
    }
    if (time_s < knots_s_[cursor_ + 1]) {
      return;
    }
  }
  const auto next = std::upper_bound(knots_s_.begin(), knots_s_.end(), time_s);
  cursor_ = static_cast<std::size_t>(next - knots_s_.begin()) - 1;
}

void Interpolator::evaluate(double time_s, std::span<AxisSetpoint> out) noexcept {
  if (!std::isnan(time_s)) {
    previous_s_ = time_s;
  }
  const std::size_t axes = axes_.size();
  const std::size_t count = std::min(out.size(), axes);
  if (finished(previous_s_)) {
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = {end_positions_[i], 0.0, 0.0};
    }
    return;
  }
  if (previous_s_ < start_s()) {
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = {coefficients_[i], 0.0, 0.0};
    }
    return;
  }
  locate(previous_s_);
  const Eigen::Map<const Coefficients> c(&coefficients_[cursor_ * 4 * axes], to_index(axes), 4);
  const double t = previous_s_ - knots_s_[cursor_];
  for (std::size_t i = 0; i < count; ++i) {
    const Index axis = to_index(i);
    const double c1 = c(axis, 1);
    const double c2 = c(axis, 2);
    const double c3 = c(axis, 3);
    out[i] = {c(axis, 0) + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + 3.0 * t * c3), 2.0 * c2 + 6.0 * t * c3};
  }
}

}  // namespace driveline::trajectory
