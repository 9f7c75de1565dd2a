#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "driveline/trajectory/interpolator.hpp"

namespace driveline::trajectory {

/// Limits of an axis, as magnitudes. Infinity: no limit.
struct AxisLimits {
  double max_velocity = std::numeric_limits<double>::infinity();      ///< rad/s or m/s, > 0
  double max_acceleration = std::numeric_limits<double>::infinity();  ///< rad/s² or m/s², > 0
};

/// The largest excess of a path over a limit, for the first axis and quantity that exceeds its limit.
struct LimitViolation {
  /// The limited quantity.
  enum class Quantity {
    kVelocity,      ///< rad/s or m/s
    kAcceleration,  ///< rad/s^2 or m/s^2
  };

  PathAxis axis;                            ///< name and kind of the axis
  std::size_t axis_index = 0;               ///< its column, from 0
  Quantity quantity = Quantity::kVelocity;  ///< the limited quantity
  double time_s = 0.0;                      ///< time on the path's time axis
  double value = 0.0;                       ///< value at that time, signed
  double limit = 0.0;                       ///< magnitude
  bool jumps = false;                       ///< the path holds its points and jumps from one to the next

  /// One sentence that names axis, quantity, value, time and limit, in the unit of the axis.
  [[nodiscard]] std::string message() const;
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const LimitViolation& error) {
  return error.message();
}

/// Evaluates the whole path at the cycle's period, like the cycle itself, and compares it with the limits (one per
/// axis). The acceleration of an axis is both the value that the interpolator reports and the change of velocity
/// between two samples, starting and ending at standstill; this detects corners of a linear path and a spline that
/// starts in motion. For held points the velocity is the change of position between two samples. An excess of up to
/// 1e-9 of the limit counts as rounding. For start-up: it allocates and takes some nanoseconds per sample and axis.
/// Leaves the interpolator's cursor at the end. Throws std::invalid_argument unless there is one pair of positive
/// limits per axis and the period is finite and at least 1 us.
[[nodiscard]] tl::expected<void, LimitViolation> check_limits(Interpolator& interpolator,
                                                              std::span<const AxisLimits> limits, double period_s);

}  // namespace driveline::trajectory
