#pragma once

#include <cstdint>

#include "driveline/slaves/msd/core/scaling.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Calculates the scaling of the factor group (MSD manual 10.3) from 607Eh, 6089h-608Dh, 608Fh and 6090h-6092h; sets
/// the factors 6093h, 6094h and 6097h. The notation indices 6089h, 608Bh and 608Dh are powers of ten between the units
/// of position, velocity and acceleration; the dimension indices 608Ah, 608Ch and 608Eh only name the units. With the
/// defaults, a position unit is an increment of the motor encoder and a velocity unit an increment per second.
/// `encoder_increments`: increments of the motor encoder per revolution. \rtsafe
[[nodiscard]] Scaling factor_group(ObjectDictionary& dictionary, std::uint32_t encoder_increments) noexcept;

}  // namespace driveline::slaves::msd
