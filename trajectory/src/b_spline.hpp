#pragma once

#include <array>

namespace driveline::trajectory::segment_detail {

/// A cubic B-spline at one of its knots: position and acceleration from the control points before, at and after it,
///   position = at + weight_before * (before - at) + weight_after * (after - at)
/// The acceleration has the same form without the first `at`.
struct BSplineKnot {
  double weight_before;
  double weight_after;
  double acceleration_before;
  double acceleration_after;
};

/// `knots`: two before it, the knot itself, two after it; the first and the last knot of a curve are repeated. \rtsafe
inline BSplineKnot b_spline_knot(const std::array<double, 5>& knots) noexcept {
  const auto& [t0, t1, t2, t3, t4] = knots;
  // De Boor's algorithm at a knot.
  const double at_before = (t2 - t0) / (t3 - t0);
  const double after_at = (t2 - t1) / (t4 - t1);
  const double middle = (t2 - t1) / (t3 - t1);
  return {(1.0 - middle) * (1.0 - at_before), middle * after_at, 6.0 / ((t3 - t0) * (t3 - t1)),
          6.0 / ((t4 - t1) * (t3 - t1))};
}

}  // namespace driveline::trajectory::segment_detail
