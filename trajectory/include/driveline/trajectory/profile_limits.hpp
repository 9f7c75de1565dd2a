#pragma once

#include <limits>

namespace driveline::trajectory {

/// Limits of a profile of an axis. The unit of length is that of the axis: rad or m.
struct ProfileLimits {
  double max_velocity = std::numeric_limits<double>::infinity();   ///< rad/s or m/s, > 0, may be infinite
  double min_velocity = -std::numeric_limits<double>::infinity();  ///< rad/s or m/s, < 0, may be infinite
  double max_acceleration = 0.0;                                   ///< rad/s^2 or m/s^2, > 0, finite
  double min_acceleration = 0.0;                                   ///< rad/s^2 or m/s^2, < 0, finite
  /// rad/s^3 or m/s^3, > 0. Infinite: the acceleration may jump, and the velocity profile is a trapezoid.
  double max_jerk = std::numeric_limits<double>::infinity();

  /// Limits that are equal in both directions, from their magnitudes. \rtsafe
  [[nodiscard]] static constexpr ProfileLimits symmetric(
      double velocity, double acceleration, double jerk = std::numeric_limits<double>::infinity()) noexcept {
    return {velocity, -velocity, acceleration, -acceleration, jerk};
  }
};

/// Whether every limit has the required sign and range; false for NaN. \rtsafe
[[nodiscard]] bool is_valid(const ProfileLimits& limits) noexcept;

}  // namespace driveline::trajectory
