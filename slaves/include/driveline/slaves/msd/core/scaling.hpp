#pragma once

#include <cstdint>

#include "driveline/slaves/cia402/ratio.hpp"

namespace driveline::slaves::msd {

/// Conversion between user units, as the drive profile defines them, and the motor shaft.
struct Scaling {
  double position_rad = 1.0;         ///< motor radians per position unit; negative with inverted polarity
  double velocity_rad_s = 1.0;       ///< motor rad/s per velocity unit; negative with inverted polarity
  bool inverted = false;             ///< positions have inverted polarity
  Ratio units_per_increment;         ///< position units per increment of the motor encoder
  Ratio increments_per_unit;         ///< inverse of units_per_increment, as a fraction
  double acceleration_rad_s2 = 1.0;  ///< motor rad/s2 per acceleration unit, always positive

  /// Converts encoder increments to position units, exactly. \rtsafe
  [[nodiscard]] std::int64_t to_units(std::int64_t increments) const noexcept {
    return units_per_increment.apply(inverted ? -increments : increments);
  }
  /// Converts position units to encoder increments, exactly. \rtsafe
  [[nodiscard]] std::int64_t to_increments(std::int64_t units) const noexcept {
    return increments_per_unit.apply(inverted ? -units : units);
  }
};

/// Returns the nearest integer of type T, limited to its range. NaN becomes 0. \rtsafe
template <typename T>
[[nodiscard]] T saturate(double value) noexcept;

}  // namespace driveline::slaves::msd
