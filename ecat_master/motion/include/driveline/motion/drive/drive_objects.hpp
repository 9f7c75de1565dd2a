#pragma once

#include <cstdint>

#include "driveline/motion/cia301/pdo_configuration.hpp"

namespace driveline::motion {

/// Number of CiA 402 drives that a device can have: drive n has the objects from 6000h + n * 800h on (CiA 301 Table
/// "Object dictionary structure", "Multiple device modules"; ETG.6010 "Multiple axis").
inline constexpr unsigned kMaxDrives = 8;

/// Index of the object of a drive that is `index` (6000h to 67FFh) in the first drive; other objects, which the drives
/// of a device share, keep their index. `drive`: below kMaxDrives.
[[nodiscard]] constexpr std::uint16_t object_of_drive(std::uint16_t index, unsigned drive) noexcept {
  const bool profile = index >= 0x6000 && index < 0x6800;
  return static_cast<std::uint16_t>(profile ? index + drive * 0x800U : index);
}

/// The inverse of object_of_drive() for any drive: 607Ah of 607Ah, 687Ah, 707Ah and so on.
[[nodiscard]] constexpr std::uint16_t object_of_first_drive(std::uint16_t index) noexcept {
  const bool profile = index >= 0x6000 && index < 0x6000 + kMaxDrives * 0x800U;
  return static_cast<std::uint16_t>(profile ? 0x6000 + (index - 0x6000U) % 0x800U : index);
}

/// The PDOs of a device as one of its drives sees them: its objects with the indices of the first drive, those of the
/// other drives as gaps. Lengths and places do not change. `drive`: below kMaxDrives.
[[nodiscard]] PdoConfiguration pdos_of_drive(PdoConfiguration pdos, unsigned drive);

}  // namespace driveline::motion
