#pragma once

#include "driveline/slaves/cia402/ratio.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Conversion between user units of the factor group and the motor shaft (MSD manual 10.3). With the defaults, a
/// position unit is an increment of the motor encoder and a velocity unit an increment per second. The notation indices
/// 6089h, 608Bh and 608Dh are powers of ten between the units of position, velocity and acceleration; the dimension
/// indices 608Ah, 608Ch and 608Eh only name the units.
struct Scaling {
  double position_rad = 1.0;         ///< motor radians per position unit; negative with inverted polarity
  double velocity_rad_s = 1.0;       ///< motor rad/s per velocity unit; negative with inverted polarity
  bool inverted = false;             ///< positions have inverted polarity
  Ratio units_per_increment;         ///< position units per increment of the motor encoder
  Ratio increments_per_unit;         ///< inverse of units_per_increment, as a fraction
  double acceleration_rad_s2 = 1.0;  ///< motor rad/s2 per acceleration unit, always positive

  /// Calculates the scaling from 607Eh, 6089h-608Dh, 608Fh and 6090h-6092h; writes the factors 6093h, 6094h and 6097h
  /// back. `encoder_increments`: increments of the motor encoder per revolution. \rtsafe
  [[nodiscard]] static Scaling from(ObjectDictionary& dictionary, std::uint32_t encoder_increments) noexcept;

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
