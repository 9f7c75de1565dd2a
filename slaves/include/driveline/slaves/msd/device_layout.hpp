#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/msd/core/control_clock.hpp"

/// Memory layout of the MSD in its slave controller (ours; the manual does not describe it).
namespace driveline::slaves::msd {

inline constexpr std::uint16_t kMailboxOutStart = 0x1000;  ///< sync manager 0
inline constexpr std::uint16_t kMailboxInStart = 0x1200;   ///< sync manager 1
inline constexpr std::uint16_t kMailboxSize = 512;         ///< default length of each mailbox, bytes
inline constexpr std::uint16_t kMailboxMinSize = 48;       ///< shortest mailbox that the drive accepts, bytes
inline constexpr std::uint16_t kOutputsStart = 0x1400;     ///< sync manager 2, three buffers
inline constexpr std::uint16_t kInputsStart = 0x1A00;      ///< sync manager 3, three buffers
inline constexpr std::uint16_t kMaxProcessData = 32;       ///< four PDOs of eight bytes (MSD manual 9.1)
inline constexpr std::uint8_t kOutputsSyncManager = 2;     ///< transfers RxPDOs
inline constexpr std::uint8_t kInputsSyncManager = 3;      ///< transfers TxPDOs
/// Time that the outputs must be complete before SYNC0 (1C32h:06): a quarter of a control step.
inline constexpr std::chrono::nanoseconds kCalcAndCopyTime = kControlStep / 4;

}  // namespace driveline::slaves::msd
