#pragma once

#include <cstdint>

#include "driveline/slaves/msd/core/control_clock.hpp"

/// How the MSD uses the memory of its slave controller (ours; the manual does not say).
namespace driveline::slaves::msd {

inline constexpr std::uint16_t kMailboxOutStart = 0x1000;  ///< sync manager 0
inline constexpr std::uint16_t kMailboxInStart = 0x1200;   ///< sync manager 1
inline constexpr std::uint16_t kMailboxSize = 512;         ///< default length of either mailbox, bytes
inline constexpr std::uint16_t kMailboxMinSize = 48;       ///< shortest mailbox the drive accepts, bytes
inline constexpr std::uint16_t kOutputsStart = 0x1400;     ///< sync manager 2, three buffers
inline constexpr std::uint16_t kInputsStart = 0x1A00;      ///< sync manager 3, three buffers
inline constexpr std::uint16_t kMaxProcessData = 32;       ///< four PDOs of eight bytes (MSD manual 9.1)
inline constexpr std::uint8_t kOutputsSyncManager = 2;     ///< carries RxPDOs
inline constexpr std::uint8_t kInputsSyncManager = 3;      ///< carries TxPDOs

}  // namespace driveline::slaves::msd
