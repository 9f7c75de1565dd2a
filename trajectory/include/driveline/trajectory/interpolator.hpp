#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Evaluates a path between its points, for all axes together.
///
/// Every segment between two points is one cubic per axis, also for linear interpolation, so the cost of evaluate()
/// depends on the number of axes only. Memory: 32 bytes per axis and segment. The factories allocate and belong to
/// start-up. One thread at a time: evaluate() moves a cursor.
class Interpolator {
 public:
  /// Straight lines: velocity is constant within a segment and jumps at the points, acceleration is reported as zero.
  [[nodiscard]] static Interpolator linear(const Path& path);
  /// Cubic spline with continuous velocity and acceleration; the acceleration is zero at both ends, the velocity there
  /// follows from the points.
  [[nodiscard]] static Interpolator natural_spline(const Path& path);
  /// Cubic spline with continuous velocity and acceleration and the given velocities (rad/s or m/s, one per axis) at
  /// both ends; an empty span stands for standstill.
  /// Throws std::invalid_argument if a span has another length or holds a value that is not finite.
  [[nodiscard]] static Interpolator clamped_spline(const Path& path, std::span<const double> start_velocity = {},
                                                   std::span<const double> end_velocity = {});

  /// The setpoints of all axes at a time on the path's own time axis, in the order of axes(). Before start_s() the
  /// first point, from end_s() on the last point, both at standstill. NaN repeats the previous call's time. Writes
  /// min(out.size(), axes().size()) setpoints.
  /// Cost: constant when time advances by up to two segments per call, a binary search otherwise. \rtsafe
  void evaluate(double time_s, std::span<AxisSetpoint> out) noexcept;

  /// True from the last point on. \rtsafe
  [[nodiscard]] bool finished(double time_s) const noexcept { return time_s >= end_s(); }

  /// \rtsafe
  [[nodiscard]] const std::vector<PathAxis>& axes() const noexcept { return axes_; }
  /// \rtsafe
  [[nodiscard]] double start_s() const noexcept { return knots_s_.front(); }
  /// \rtsafe
  [[nodiscard]] double end_s() const noexcept { return knots_s_.back(); }
  /// \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return end_s() - start_s(); }

 private:
  // `moments` holds the second derivative at every knot, one after the other, for all axes each.
  Interpolator(const Path& path, std::span<const double> moments);

  void locate(double time_s) noexcept;

  std::vector<PathAxis> axes_;
  std::vector<double> knots_s_;
  std::vector<double> coefficients_;   // per segment a column-major matrix axes x 4, ascending powers
  std::vector<double> end_positions_;  // of the last point, per axis
  std::size_t cursor_ = 0;             // segment of the previous call
  double previous_s_;                  // time of the previous call
};

}  // namespace driveline::trajectory
