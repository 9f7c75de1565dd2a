#include "trapezoid_frontier.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {

TrapezoidStretch::TrapezoidStretch(const Boundary& boundary) noexcept
    : b_(boundary),
      lowest_(std::max(boundary.v0, boundary.v1)),
      per_speed_(1.0 / boundary.rise + 1.0 / boundary.fall) {}

double TrapezoidStretch::duration_of(double velocity) const noexcept {
  return (velocity - b_.v0) / b_.rise + (velocity - b_.v1) / b_.fall;
}

double TrapezoidStretch::way_of(double velocity) const noexcept {
  return (velocity - b_.v0) * (velocity + b_.v0) / (2.0 * b_.rise) +
         (velocity - b_.v1) * (velocity + b_.v1) / (2.0 * b_.fall);
}

double TrapezoidStretch::velocity_at(double duration_s) const noexcept {
  return std::clamp(lowest_ + (duration_s - shortest_s()) / per_speed_, lowest_, b_.top);
}

std::optional<TrapezoidStretch::Point> TrapezoidStretch::next(double displacement, double from_s,
                                                              bool reached) const noexcept {
  const double start_s = std::max(from_s, shortest_s());
  const double missing = displacement - this->displacement({start_s});
  if ((missing <= 0.0) == reached) {
    return Point{start_s};
  }
  const double velocity = velocity_at(start_s);
  // d way / d velocity = velocity * per_speed_.
  const double squared = velocity * velocity + 2.0 * missing / per_speed_;
  if (!reached) {
    // The displacement decreases only while the axis moves backwards.
    return velocity < 0.0 && squared >= 0.0 ? std::optional(Point{duration_of(-std::sqrt(squared))}) : std::nullopt;
  }
  const double top_s = duration_of(b_.top);
  if (start_s >= top_s) {
    return Point{start_s + missing / b_.top};
  }
  const double needed = std::sqrt(squared);
  return Point{needed <= b_.top ? duration_of(needed) : top_s + (displacement - way_of(b_.top)) / b_.top};
}

double TrapezoidStretch::displacement(const Point& point) const noexcept {
  const double velocity = velocity_at(point.duration_s);
  return way_of(velocity) + std::max(0.0, point.duration_s - duration_of(velocity)) * velocity;
}

PhaseList TrapezoidStretch::phases(const Point& point) const noexcept {
  const double velocity = velocity_at(point.duration_s);
  PhaseList list;
  list.push((velocity - b_.v0) / b_.rise, b_.rise, 0.0);
  if (velocity >= b_.top) {
    list.push(point.duration_s - duration_of(velocity), 0.0, 0.0);
  }
  list.push((velocity - b_.v1) / b_.fall, -b_.fall, 0.0);
  return list;
}

}  // namespace driveline::trajectory
