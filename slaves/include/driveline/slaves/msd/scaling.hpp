#pragma once

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Conversion between user units of the factor group and the motor shaft (MSD manual 10.3). With the defaults a
/// position unit is an increment of the motor encoder and a velocity unit an increment per second. The notation
/// and dimension indices (6089h-608Eh) are not there yet; they count as 0.
struct Scaling {
  double position_rad = 1.0;         ///< motor radians per position unit; negative with inverted polarity
  double velocity_rad_s = 1.0;       ///< motor rad/s per velocity unit; negative with inverted polarity
  double acceleration_rad_s2 = 1.0;  ///< motor rad/s2 per acceleration unit, always positive

  /// From 607Eh, 608Fh and 6090h-6092h; writes the calculated factors 6093h, 6094h and 6097h back. \rtsafe
  [[nodiscard]] static Scaling from(ObjectDictionary& dictionary) noexcept;
};

/// Nearest integer of type T, limited to its range. NaN becomes 0. \rtsafe
template <typename T>
[[nodiscard]] T saturate(double value) noexcept;

}  // namespace driveline::slaves::msd
