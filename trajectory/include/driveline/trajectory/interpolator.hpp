#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/trajectory/interpolation_method.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Evaluates a path between its points, for all axes together.
///
/// Every segment between two points is one polynomial per axis, or half a period of a cosine, and all of a path are of
/// one kind, so the cost of evaluate() depends on kind and number of axes only. Memory per axis and segment: 8 bytes
/// (hold), 16 (linear, cosine), 48 (quintic), 32 (the others). The factories allocate and belong to start-up. One
/// thread at a time: evaluate() moves a cursor.
class Interpolator {
 public:
  /// The method with its defaults.
  [[nodiscard]] static Interpolator make(const Path& path, InterpolationMethod method);
  /// Each point is held until the time of the next one, where the position jumps. Velocity and acceleration are
  /// reported as zero.
  [[nodiscard]] static Interpolator hold(const Path& path);
  /// Straight lines: velocity is constant within a segment and jumps at the points, acceleration is reported as zero.
  [[nodiscard]] static Interpolator linear(const Path& path);
  /// Cubics with the velocities of the path at the points. Where an axis has none: standstill at both ends, and in
  /// between the velocity of the parabola through a point and its neighbours. The acceleration jumps at the points.
  [[nodiscard]] static Interpolator hermite(const Path& path);
  /// Cubic spline with continuous velocity and acceleration; the acceleration is zero at both ends, the velocity there
  /// follows from the points.
  [[nodiscard]] static Interpolator natural_spline(const Path& path);
  /// Cubic spline with continuous velocity and acceleration and the given velocities (rad/s or m/s, one per axis) at
  /// both ends; an empty span stands for standstill.
  /// Throws std::invalid_argument if a span has another length or holds a value that is not finite.
  [[nodiscard]] static Interpolator clamped_spline(const Path& path, std::span<const double> start_velocity = {},
                                                   std::span<const double> end_velocity = {});
  /// Fifth degree, with the velocities and accelerations of the path at the points; both are continuous. Where an axis
  /// has none of either: zero at both ends, and in between that of the polynomial through the point and its nearest
  /// neighbours, five points in all.
  [[nodiscard]] static Interpolator quintic(const Path& path);
  /// From point to point in half a period of a cosine, at standstill at each; the acceleration jumps there. As the MSD
  /// drive does it with interpolation type 5.
  [[nodiscard]] static Interpolator cosine(const Path& path);
  /// Cubic B-spline, continuous to the acceleration: goes from the first point to the last one, at standstill at both,
  /// and passes by those in between, always within the range of the points around. For equal steps it is the uniform
  /// one, (before + 4 at + after) / 6 at a point; for others its control points are moved along the straight lines
  /// through the points so that an even motion stays even (Schoenberg's spline of these lines).
  [[nodiscard]] static Interpolator b_spline(const Path& path);

  /// The setpoints of all axes at a time on the path's own time axis, in the order of axes(). Before start_s() the
  /// first point, from end_s() on the last point, both at standstill. NaN repeats the previous call's time. Writes
  /// min(out.size(), axes().size()) setpoints.
  /// Cost: constant when time advances by up to two segments per call, a binary search otherwise. \rtsafe
  void evaluate(double time_s, std::span<AxisSetpoint> out) noexcept;

  /// True from the last point on. \rtsafe
  [[nodiscard]] bool finished(double time_s) const noexcept { return time_s >= end_s(); }

  /// \rtsafe
  [[nodiscard]] InterpolationMethod method() const noexcept { return method_; }
  /// \rtsafe
  [[nodiscard]] const std::vector<PathAxis>& axes() const noexcept { return axes_; }
  /// \rtsafe
  [[nodiscard]] double start_s() const noexcept { return knots_s_.front(); }
  /// \rtsafe
  [[nodiscard]] double end_s() const noexcept { return knots_s_.back(); }
  /// \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return end_s() - start_s(); }

 private:
  Interpolator(const Path& path, InterpolationMethod method, std::vector<double> coefficients);

  void locate(double time_s) noexcept;
  void evaluate_segment(double t, std::span<AxisSetpoint> out) const noexcept;

  InterpolationMethod method_;
  std::vector<PathAxis> axes_;
  std::vector<double> knots_s_;
  std::vector<double> coefficients_;   // per segment a matrix with a row per axis, column-major
  std::size_t stride_;                 // coefficients of one segment
  std::vector<double> end_positions_;  // of the last point, per axis
  std::size_t cursor_ = 0;             // segment of the previous call
  double previous_s_;                  // time of the previous call
};

}  // namespace driveline::trajectory
