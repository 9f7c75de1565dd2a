#include "driveline/trajectory/interpolator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "path_segments.hpp"
#include "segment.hpp"

namespace driveline::trajectory {
namespace {

using Method = InterpolationMethod;

}  // namespace

Interpolator::Interpolator(const Path& path, Method method, std::vector<double> coefficients)
    : method_(method),
      axes_(path.axes()),
      knots_s_(path.times_s().begin(), path.times_s().end()),
      coefficients_(std::move(coefficients)),
      stride_(coefficients_.size() / (path.points() - 1)),
      end_positions_(path.positions(path.points() - 1).begin(), path.positions(path.points() - 1).end()),
      previous_s_(path.start_s()) {}

Interpolator Interpolator::make(const Path& path, Method method) {
  switch (method) {
    case Method::kHold:
      return hold(path);
    case Method::kLinear:
      return linear(path);
    case Method::kHermite:
      return hermite(path);
    case Method::kNaturalSpline:
      return natural_spline(path);
    case Method::kQuintic:
      return quintic(path);
    case Method::kCosine:
      return cosine(path);
    case Method::kBSpline:
      return b_spline(path);
    case Method::kClampedSpline:
      break;
  }
  return clamped_spline(path);
}

Interpolator Interpolator::hold(const Path& path) {
  return {path, Method::kHold, segment_detail::hold_segments(path)};
}

Interpolator Interpolator::linear(const Path& path) {
  return {path, Method::kLinear, segment_detail::linear_segments(path)};
}

Interpolator Interpolator::hermite(const Path& path) {
  return {path, Method::kHermite, segment_detail::hermite_segments(path)};
}

Interpolator Interpolator::natural_spline(const Path& path) {
  return {path, Method::kNaturalSpline, segment_detail::natural_segments(path)};
}

Interpolator Interpolator::clamped_spline(const Path& path, std::span<const double> start_velocity,
                                          std::span<const double> end_velocity) {
  return {path, Method::kClampedSpline, segment_detail::clamped_segments(path, start_velocity, end_velocity)};
}

Interpolator Interpolator::quintic(const Path& path) {
  return {path, Method::kQuintic, segment_detail::quintic_segments(path)};
}

Interpolator Interpolator::cosine(const Path& path) {
  return {path, Method::kCosine, segment_detail::cosine_segments(path)};
}

Interpolator Interpolator::b_spline(const Path& path) {
  return {path, Method::kBSpline, segment_detail::b_spline_segments(path)};
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

void Interpolator::evaluate_segment(double t, std::span<AxisSetpoint> out) const noexcept {
  const std::size_t axes = axes_.size();
  const double* const c = &coefficients_[cursor_ * stride_];
  switch (method_) {
    case Method::kHold:
      return segment_detail::evaluate_polynomial<1>(c, axes, t, out);
    case Method::kLinear:
      return segment_detail::evaluate_polynomial<2>(c, axes, t, out);
    case Method::kQuintic:
      return segment_detail::evaluate_polynomial<6>(c, axes, t, out);
    case Method::kCosine:
      return segment_detail::evaluate_cosine(c, axes, t, knots_s_[cursor_ + 1] - knots_s_[cursor_], out);
    case Method::kHermite:
    case Method::kNaturalSpline:
    case Method::kClampedSpline:
    case Method::kBSpline:
      return segment_detail::evaluate_polynomial<4>(c, axes, t, out);
  }
}

void Interpolator::evaluate(double time_s, std::span<AxisSetpoint> out) noexcept {
  if (!std::isnan(time_s)) {
    previous_s_ = time_s;
  }
  out = out.first(std::min(out.size(), axes_.size()));
  if (finished(previous_s_)) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = {end_positions_[i], 0.0, 0.0};
    }
    return;
  }
  if (previous_s_ < start_s()) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = {coefficients_[i], 0.0, 0.0};
    }
    return;
  }
  locate(previous_s_);
  evaluate_segment(previous_s_ - knots_s_[cursor_], out);
}

}  // namespace driveline::trajectory
