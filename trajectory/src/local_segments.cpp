// Segment coefficients of curves that depend only on a few neighbouring points.
#include <algorithm>

#include "path_columns.hpp"
#include "path_segments.hpp"
#include "segment.hpp"

namespace driveline::trajectory::segment_detail {
namespace {

/// Velocity and acceleration of all axes at one point.
struct Derivatives {
  AxisColumn velocity;
  AxisColumn acceleration;
};

/// Derivatives of the polynomial through the point and its nearest neighbours, `window` points in all, in Newton's
/// form.
Derivatives estimate(const Path& path, std::size_t point, std::size_t window) {
  const std::size_t count = std::min(window, path.points());
  const std::size_t before = count / 2;
  const std::size_t first = std::min(std::max(point, before) - before, path.points() - count);
  const auto time_s = path.times_s().subspan(first, count);
  const auto axes = to_index(path.axes().size());
  Eigen::MatrixXd divided(axes, to_index(count));
  for (std::size_t k = 0; k < count; ++k) divided.col(to_index(k)) = column(path.positions(first + k));
  for (std::size_t order = 1; order < count; ++order) {
    for (std::size_t k = count - 1; k >= order; --k) {
      divided.col(to_index(k)) =
          (divided.col(to_index(k)) - divided.col(to_index(k) - 1)).eval() / (time_s[k] - time_s[k - order]);
    }
  }
  AxisColumn position = divided.col(to_index(count) - 1);
  Derivatives derivatives{AxisColumn::Zero(axes), AxisColumn::Zero(axes)};
  for (std::size_t k = count - 1; k-- > 0;) {
    const double t = path.times_s()[point] - time_s[k];
    derivatives.acceleration = derivatives.acceleration * t + 2.0 * derivatives.velocity;
    derivatives.velocity = derivatives.velocity * t + position;
    position = position * t + divided.col(to_index(k));
  }
  return derivatives;
}

/// The derivatives that the path gives; otherwise standstill at its ends, and estimates in between.
Derivatives derivatives_at(const Path& path, std::size_t point, std::size_t window) {
  const auto axes = to_index(path.axes().size());
  const bool is_end = point == 0 || point + 1 == path.points();
  Derivatives derivatives =
      is_end ? Derivatives{AxisColumn::Zero(axes), AxisColumn::Zero(axes)} : estimate(path, point, window);
  for (std::size_t i = 0; i < path.axes().size(); ++i) {
    if (path.axes()[i].gives_velocity) derivatives.velocity(to_index(i)) = path.velocities(point)[i];
    if (path.axes()[i].gives_acceleration) derivatives.acceleration(to_index(i)) = path.accelerations(point)[i];
  }
  return derivatives;
}

using FillSegment = void (*)(double* c, std::size_t axes, double step, const Knot& from, const Knot& to) noexcept;

std::vector<double> osculating_segments(const Path& path, std::size_t columns, std::size_t window, FillSegment fill) {
  const std::size_t axes = path.axes().size();
  std::vector<double> coefficients((path.points() - 1) * columns * axes);
  Derivatives here = derivatives_at(path, 0, window);
  for (std::size_t k = 0; k + 1 < path.points(); ++k) {
    Derivatives next = derivatives_at(path, k + 1, window);
    fill(&coefficients[k * columns * axes], axes, step_s(path, k),
         {path.positions(k).data(), here.velocity.data(), here.acceleration.data()},
         {path.positions(k + 1).data(), next.velocity.data(), next.acceleration.data()});
    here = std::move(next);
  }
  return coefficients;
}

/// Coefficients: position, and its change in `per(step)` seconds.
template <typename Per>
std::vector<double> two_columns(const Path& path, Per per) {
  const std::size_t axes = path.axes().size();
  std::vector<double> coefficients((path.points() - 1) * 2 * axes);
  for (std::size_t k = 0; k + 1 < path.points(); ++k) {
    fill_line(&coefficients[k * 2 * axes], axes, per(step_s(path, k)), path.positions(k).data(),
              path.positions(k + 1).data());
  }
  return coefficients;
}

}  // namespace

std::vector<double> hold_segments(const Path& path) {
  std::vector<double> coefficients;
  coefficients.reserve((path.points() - 1) * path.axes().size());
  for (std::size_t k = 0; k + 1 < path.points(); ++k) {
    coefficients.insert(coefficients.end(), path.positions(k).begin(), path.positions(k).end());
  }
  return coefficients;
}

std::vector<double> linear_segments(const Path& path) {
  return two_columns(path, [](double step) { return step; });
}

std::vector<double> cosine_segments(const Path& path) {
  return two_columns(path, [](double) { return 1.0; });
}

std::vector<double> hermite_segments(const Path& path) {
  constexpr std::size_t kParabola = 3;
  return osculating_segments(path, 4, kParabola, fill_cubic);
}

std::vector<double> quintic_segments(const Path& path) {
  constexpr std::size_t kQuartic = 5;
  return osculating_segments(path, 6, kQuartic, fill_quintic);
}

}  // namespace driveline::trajectory::segment_detail
