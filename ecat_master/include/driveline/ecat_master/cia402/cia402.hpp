#pragma once

#include <cstdint>
#include <string_view>

#include "driveline/snapshot/snapshot.hpp"

/// The power drive system of CiA 402-2 (IEC 61800-7-201) as the master sees it: status word in, control word out.
namespace driveline::ecat_master::cia402 {

using snapshot::AxisState;

/// Modes of operation, object 6060h.
enum class Mode : std::int8_t { kCyclicPosition = 8, kCyclicVelocity = 9, kCyclicTorque = 10 };

/// Control word commands, object 6040h (CiA 402-2 Table "Command coding").
namespace command {
/// Control word: to Switch on disabled.
inline constexpr std::uint16_t kDisableVoltage = 0x0000;
/// Control word: stops as 605Ah says.
inline constexpr std::uint16_t kQuickStop = 0x0002;
/// Control word: to Ready to switch on.
inline constexpr std::uint16_t kShutdown = 0x0006;
/// Control word: to Switched on.
inline constexpr std::uint16_t kSwitchOn = 0x0007;
/// Control word: to Operation enabled.
inline constexpr std::uint16_t kEnableOperation = 0x000F;
/// Control word, bit 7: its rising edge resets a fault.
inline constexpr std::uint16_t kFaultReset = 0x0080;
}  // namespace command

/// The state that the master wants an axis in.
enum class Goal : std::uint8_t {
  kDisabled,   ///< power off, via Shutdown and Disable voltage
  kEnabled,    ///< Operation enabled, through every state on the way
  kQuickStop,  ///< stopped by the drive's own quick stop, then off
};

/// State coded in a status word. Bit 4 (voltage) and bit 7 (warning) do not take part (CiA 402-2, masks 4Fh and 6Fh).
/// \rtsafe
[[nodiscard]] AxisState decode_state(std::uint16_t status_word) noexcept;

/// Name as in the standard.
[[nodiscard]] std::string_view to_text(AxisState state) noexcept;
/// "csp", "csv" or "cst", as line descriptions name them.
[[nodiscard]] std::string_view to_text(Mode mode) noexcept;

/// The command that brings an axis one state closer to the goal. Never skips a state: the drives require the commands
/// one after the other (MSD manual, Table 11.4). In Fault it is Disable voltage: faults are reset on request only. An
/// axis in an unknown state is never switched on; it gets Quick stop when it shall stop. \rtsafe
[[nodiscard]] std::uint16_t next_control_word(AxisState state, Goal goal) noexcept;

}  // namespace driveline::ecat_master::cia402
