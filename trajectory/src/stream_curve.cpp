#include "driveline/trajectory/stream_curve.hpp"

#include <algorithm>
#include <utility>

#include "b_spline.hpp"
#include "segment.hpp"

namespace driveline::trajectory {
namespace {

/// Number of setpoints stored before the current segment.
constexpr std::uint64_t kHistory = 2;

}  // namespace

StreamMethodFacts facts_of(StreamMethod method) noexcept {
  switch (method) {
    case StreamMethod::kHold:
      return {Continuity::kNone, 0, 1};
    case StreamMethod::kLinear:
      return {Continuity::kPosition, 1, 2};
    case StreamMethod::kHermite:
      return {Continuity::kVelocity, 1, 4};
    case StreamMethod::kQuintic:
      return {Continuity::kAcceleration, 1, 6};
    case StreamMethod::kBSpline:
      return {Continuity::kAcceleration, 3, 4};
    case StreamMethod::kCubic:
      break;
  }
  return {Continuity::kVelocity, 2, 4};
}

StreamCurve::StreamCurve(StreamMethod method, std::size_t axes, std::size_t capacity, double hold_s)
    : method_(method),
      axes_(axes),
      capacity_(capacity),
      delay_(facts_of(method).delay),
      hold_s_(hold_s),
      times_s_(capacity + 1 + kHistory),
      positions_(times_s_.size() * axes),
      velocities_(times_s_.size() * axes),
      accelerations_(times_s_.size() * axes),
      from_{Row(axes), Row(axes)},
      to_{Row(axes), Row(axes)},
      coefficients_(facts_of(method).columns * axes) {
  clear();
}

void StreamCurve::clear() noexcept {
  segment_ = end_ = kHistory;
  begun_ = false;
}

void StreamCurve::add(double time_s, std::span<const StreamPoint> points) noexcept {
  time_of(end_) = time_s;
  for (std::size_t i = 0; i < axes_; ++i) {
    row(positions_, end_)[i] = points[i].position;
    row(velocities_, end_)[i] = points[i].velocity;
    row(accelerations_, end_)[i] = points[i].acceleration;
  }
  ++end_;
  if (end_ == kHistory + 2) extend_backwards();
}

/// Extends the straight line between the first two setpoints into the past.
void StreamCurve::extend_backwards() noexcept {
  for (std::uint64_t index = kHistory; index-- > 0;) {
    time_of(index) = 2.0 * time_of(index + 1) - time_of(index + 2);
    for (std::size_t i = 0; i < axes_; ++i) {
      row(positions_, index)[i] = 2.0 * row(positions_, index + 1)[i] - row(positions_, index + 2)[i];
    }
  }
}

bool StreamCurve::advance(double time_s) noexcept {
  if (!begun_) {
    if (!complete(segment_) || time_s < time_of(segment_)) return false;
    begun_ = true;
    start_segment(false);
  }
  const std::uint64_t before = segment_;
  while (complete(segment_ + 1) && time_s >= time_of(segment_ + 1)) ++segment_;
  if (segment_ != before) start_segment(segment_ == before + 1);
  const double end_s = segment_ + 1 < end_ ? time_of(segment_ + 1) : time_of(segment_) + hold_s_;
  return time_s <= end_s;
}

void StreamCurve::estimate_velocities(std::uint64_t index, Row& velocities) noexcept {
  const double before_s = time_of(index) - time_of(index - 1);
  const double after_s = time_of(index + 1) - time_of(index);
  const double* const before = row(positions_, index - 1);
  const double* const at = row(positions_, index);
  const double* const after = row(positions_, index + 1);
  const double share = after_s / (before_s + after_s);
  for (std::size_t i = 0; i < axes_; ++i) {
    velocities[i] = share * (at[i] - before[i]) / before_s + (1.0 - share) * (after[i] - at[i]) / after_s;
  }
}

/// As for a path: evaluates the straight lines through the setpoints at the mean of three knots.
StreamCurve::ControlPoints StreamCurve::control_points(std::uint64_t index) noexcept {
  const double before_s = time_of(index) - time_of(index - 1);
  const double after_s = time_of(index + 1) - time_of(index);
  const double shift = (after_s - before_s) / 3.0;
  const double* const at = row(positions_, index);
  if (shift > 0.0) return {at, row(positions_, index + 1), shift / after_s};
  return {at, row(positions_, index - 1), -shift / before_s};
}

void StreamCurve::approximate(std::uint64_t index, Row& positions, Row& accelerations) noexcept {
  const auto knot = segment_detail::b_spline_knot(
      {time_of(index - 2), time_of(index - 1), time_of(index), time_of(index + 1), time_of(index + 2)});
  const ControlPoints points = control_points(index);
  const ControlPoints points_before = control_points(index - 1);
  const ControlPoints points_after = control_points(index + 1);
  for (std::size_t i = 0; i < axes_; ++i) {
    const double at = points.of(i);
    const double before = points_before.of(i) - at;
    const double after = points_after.of(i) - at;
    positions[i] = at + knot.weight_before * before + knot.weight_after * after;
    accelerations[i] = knot.acceleration_before * before + knot.acceleration_after * after;
  }
}

/// Computes what the method derives from several setpoints around `index`.
void StreamCurve::derive(std::uint64_t index, Ends& ends) noexcept {
  if (method_ == StreamMethod::kCubic) estimate_velocities(index, ends.derivatives);
  if (method_ == StreamMethod::kBSpline) approximate(index, ends.positions, ends.derivatives);
}

/// `next_one`: the previous segment ended where this one starts.
void StreamCurve::start_segment(bool next_one) noexcept {
  using segment_detail::Knot;
  const std::uint64_t next = segment_ + 1;
  start_s_ = time_of(segment_);
  double* const c = coefficients_.data();
  if (method_ == StreamMethod::kHold) {
    std::copy_n(row(positions_, segment_), axes_, c);
    return;
  }
  const double step = time_of(next) - time_of(segment_);
  if (next_one) {
    std::swap(from_, to_);
  } else {
    derive(segment_, from_);
  }
  derive(next, to_);
  const Knot from{row(positions_, segment_), row(velocities_, segment_), row(accelerations_, segment_)};
  const Knot to{row(positions_, next), row(velocities_, next), row(accelerations_, next)};
  switch (method_) {
    case StreamMethod::kLinear:
      return segment_detail::fill_line(c, axes_, step, from.position, to.position);
    case StreamMethod::kHermite:
      return segment_detail::fill_cubic(c, axes_, step, from, to);
    case StreamMethod::kQuintic:
      return segment_detail::fill_quintic(c, axes_, step, from, to);
    case StreamMethod::kBSpline:
      return segment_detail::fill_moments(c, axes_, step, {from_.positions.data(), nullptr, from_.derivatives.data()},
                                          {to_.positions.data(), nullptr, to_.derivatives.data()});
    case StreamMethod::kHold:
    case StreamMethod::kCubic:
      return segment_detail::fill_cubic(c, axes_, step, {from.position, from_.derivatives.data()},
                                        {to.position, to_.derivatives.data()});
  }
}

void StreamCurve::evaluate(double time_s, std::span<AxisSetpoint> out) const noexcept {
  const double t = time_s - start_s_;
  const double* const c = coefficients_.data();
  out = out.first(axes_);
  switch (coefficients_.size() / axes_) {
    case 1:
      return segment_detail::evaluate_polynomial<1>(c, axes_, t, out);
    case 2:
      return segment_detail::evaluate_polynomial<2>(c, axes_, t, out);
    case 4:
      return segment_detail::evaluate_polynomial<4>(c, axes_, t, out);
    default:
      return segment_detail::evaluate_polynomial<6>(c, axes_, t, out);
  }
}

}  // namespace driveline::trajectory
