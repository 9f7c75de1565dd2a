#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/trajectory/interpolation_method.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Evaluates a path between its points, for all axes.
///
/// Every segment between two points is one polynomial per axis, or half a period of a cosine, and all segments of a
/// path are of the same kind, so the cost of evaluate() depends only on the kind and the number of axes. Memory per
/// axis and segment: 8 bytes (hold), 16 (linear, cosine), 48 (quintic), 32 (the others). The factories allocate, so
/// call them at start-up. One thread at a time: evaluate() moves a cursor.
class Interpolator {
 public:
  /// Creates an interpolator with the method and its defaults.
  [[nodiscard]] static Interpolator make(const Path& path, InterpolationMethod method);
  /// Holds each point until the time of the next one, where the position jumps. Velocity and acceleration are reported
  /// as zero.
  [[nodiscard]] static Interpolator hold(const Path& path);
  /// Straight lines: the velocity is constant within a segment and jumps at the points; the acceleration is reported as
  /// zero.
  [[nodiscard]] static Interpolator linear(const Path& path);
  /// Cubics with the velocities of the path at the points. For an axis without velocities: standstill at both ends, and
  /// in between the velocity of the parabola through a point and its neighbours. The acceleration jumps at the points.
  [[nodiscard]] static Interpolator hermite(const Path& path);
  /// Cubic spline with continuous velocity and acceleration; at both ends the acceleration is zero and the velocity
  /// follows from the points.
  [[nodiscard]] static Interpolator natural_spline(const Path& path);
  /// Cubic spline with continuous velocity and acceleration and the given velocities (rad/s or m/s, one per axis) at
  /// both ends; an empty span means standstill. Throws std::invalid_argument if a span has another length or holds a
  /// value that is not finite.
  [[nodiscard]] static Interpolator clamped_spline(const Path& path, std::span<const double> start_velocity = {},
                                                   std::span<const double> end_velocity = {});
  /// Fifth degree, with the velocities and accelerations of the path at the points; both are continuous. Missing values
  /// are zero at both ends and in between those of the polynomial through the point and its nearest neighbours, five
  /// points in all.
  [[nodiscard]] static Interpolator quintic(const Path& path);
  /// From point to point in half a period of a cosine, at standstill at each point, where the acceleration jumps. Like
  /// interpolation type 5 of the MSD drive.
  [[nodiscard]] static Interpolator cosine(const Path& path);
  /// Cubic B-spline, continuous up to the acceleration: starts at the first point and ends at the last one, at
  /// standstill at both. It does not pass through the points in between, but always stays within the range of the
  /// surrounding points. For equal steps it is the uniform B-spline, (before + 4 at + after) / 6 at a point; for other
  /// steps its control points are shifted along the straight lines through the points so that a uniform motion stays
  /// uniform (Schoenberg's spline of these lines).
  [[nodiscard]] static Interpolator b_spline(const Path& path);

  /// Writes the setpoints of all axes at a time on the path's own time axis, in the order of axes(), but at most
  /// out.size(). Before start_s() the first point, from end_s() on the last point, both at standstill. NaN repeats the
  /// time of the previous call.
  /// Cost: constant if time advances by up to two segments per call, otherwise a binary search. \rtsafe
  void evaluate(double time_s, std::span<AxisSetpoint> out) noexcept;

  /// Whether the last point has been reached. \rtsafe
  [[nodiscard]] bool finished(double time_s) const noexcept { return time_s >= end_s(); }

  /// Interpolation method. \rtsafe
  [[nodiscard]] InterpolationMethod method() const noexcept { return method_; }
  /// Axes of the path. \rtsafe
  [[nodiscard]] const std::vector<PathAxis>& axes() const noexcept { return axes_; }
  /// Time of the first point. \rtsafe
  [[nodiscard]] double start_s() const noexcept { return knots_s_.front(); }
  /// Time of the last point. \rtsafe
  [[nodiscard]] double end_s() const noexcept { return knots_s_.back(); }
  /// Time from the first to the last point. \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return end_s() - start_s(); }

 private:
  Interpolator(const Path& path, InterpolationMethod method, std::vector<double> coefficients);

  void locate(double time_s) noexcept;
  void evaluate_segment(double t, std::span<AxisSetpoint> out) const noexcept;

  InterpolationMethod method_;
  std::vector<PathAxis> axes_;
  std::vector<double> knots_s_;
  std::vector<double> coefficients_;   // per segment a matrix with one row per axis, column-major
  std::size_t stride_;                 // number of coefficients per segment
  std::vector<double> end_positions_;  // positions of the last point, one per axis
  std::size_t cursor_ = 0;             // segment of the previous call
  double previous_s_;                  // time of the previous call
};

}  // namespace driveline::trajectory
