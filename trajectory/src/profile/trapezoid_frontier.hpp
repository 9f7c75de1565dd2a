#pragma once

#include <limits>
#include <optional>

#include "boundary.hpp"

namespace driveline::trajectory {

/// The motions with unlimited jerk that move farthest in a given time: full acceleration to a velocity, which is held
/// if it is the largest one, and full deceleration. The accelerations of a Boundary are ignored.
class TrapezoidStretch {
 public:
  explicit TrapezoidStretch(const Boundary& boundary) noexcept;

  [[nodiscard]] double shortest_s() const noexcept { return duration_of(lowest_); }
  [[nodiscard]] double longest_s() const noexcept { return std::numeric_limits<double>::infinity(); }
  [[nodiscard]] double shortest_way() const noexcept { return way_of(lowest_); }

  /// See JerkStretch::Point.
  struct Point {
    double duration_s;
  };
  [[nodiscard]] Point shortest() const noexcept { return {shortest_s()}; }
  [[nodiscard]] std::optional<Point> next(double displacement, double from_s, bool reached) const noexcept;
  [[nodiscard]] Point at(double duration_s) const noexcept { return {duration_s}; }
  [[nodiscard]] double displacement(const Point& point) const noexcept;
  [[nodiscard]] PhaseList phases(const Point& point) const noexcept;

 private:
  [[nodiscard]] double duration_of(double velocity) const noexcept;
  [[nodiscard]] double way_of(double velocity) const noexcept;
  [[nodiscard]] double velocity_at(double duration_s) const noexcept;

  Boundary b_;
  double lowest_;     // peak velocity of the shortest motion
  double per_speed_;  // time in s to increase and decrease the velocity by one unit
};

/// All farthest motions: one stretch without a gap.
class TrapezoidFrontier {
 public:
  using Stretch = TrapezoidStretch;
  static constexpr bool kJumps = true;  ///< whether the acceleration jumps

  explicit TrapezoidFrontier(const Boundary& boundary) noexcept : b_(boundary) {}

  [[nodiscard]] bool has_short_stretch() const noexcept { return false; }
  [[nodiscard]] TrapezoidStretch short_stretch() const noexcept { return main_stretch(); }
  [[nodiscard]] TrapezoidStretch main_stretch() const noexcept { return TrapezoidStretch(b_); }

 private:
  Boundary b_;
};

}  // namespace driveline::trajectory
