#pragma once

#include <cstdint>
#include <string_view>

#include "driveline/snapshot/snapshot.hpp"

/// The power drive system of CiA 402-2 (IEC 61800-7-201) as used by the master: status word in, control word out.
namespace driveline::motion::cia402 {

using snapshot::AxisState;

/// Modes of operation, object 6060h. In modes below kCyclicPosition the drive generates or interpolates the motion
/// itself, commanded by bits of the control word.
enum class Mode : std::int8_t {
  kProfilePosition = 1,
  kVelocity = 2,  ///< for frequency converters; U/f operation of a servo drive
  kProfileVelocity = 3,
  kHoming = 6,
  kInterpolatedPosition = 7,
  kCyclicPosition = 8,
  kCyclicVelocity = 9,
  kCyclicTorque = 10
};

/// Whether the drive follows setpoints that are sent in every cycle. \rtsafe
[[nodiscard]] constexpr bool cyclic(Mode mode) noexcept {
  return mode >= Mode::kCyclicPosition;
}

/// Whether the drive follows position setpoints that are sent in every cycle. \rtsafe
[[nodiscard]] constexpr bool by_position(Mode mode) noexcept {
  return mode == Mode::kCyclicPosition || mode == Mode::kInterpolatedPosition;
}

/// Whether the drive generates the motion itself, from requests. \rtsafe
[[nodiscard]] constexpr bool by_drive(Mode mode) noexcept {
  return !cyclic(mode) && !by_position(mode);
}

/// Control word commands, object 6040h (CiA 402-2 Table "Command coding").
namespace command {
/// Control word: to Switch on disabled.
inline constexpr std::uint16_t kDisableVoltage = 0x0000;
/// Control word: stops according to 605Ah.
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

/// Mode-specific bits of the control word (CiA 402-2; MSD manual Tables 12.4, 12.8, 12.10, 12.13).
namespace command_bit {
/// Profile position: a new setpoint is available.
inline constexpr std::uint16_t kNewSetpoint = 0x0010;
/// Homing: runs while the bit is set.
inline constexpr std::uint16_t kHomingStart = 0x0010;
/// Interpolated position: the drive follows setpoints.
inline constexpr std::uint16_t kInterpolate = 0x0010;
/// Profile position: the movement starts at once, not after the previous one.
inline constexpr std::uint16_t kImmediately = 0x0020;
/// Profile position: the setpoint is a distance.
inline constexpr std::uint16_t kRelative = 0x0040;
/// Velocity mode: the drive follows the target along its ramp, which is not disabled (bit 4, CiA 402-2), not frozen (5)
/// and not set to zero (6).
inline constexpr std::uint16_t kFollowRamp = 0x0070;
/// The axis stops according to 605Dh, and continues when the bit is cleared.
inline constexpr std::uint16_t kHalt = 0x0100;
/// All mode-specific bits.
inline constexpr std::uint16_t kAll = 0x0170;
}  // namespace command_bit

/// Mode-specific bits of the status word (CiA 402-2; MSD manual Table 12.14).
namespace status_bit {
/// The target is reached; in homing: the axis is at standstill.
inline constexpr std::uint16_t kTargetReached = 0x0400;
/// Profile position: the drive has taken the new setpoint.
inline constexpr std::uint16_t kSetpointAcknowledge = 0x1000;
/// Cyclic modes: the drive follows setpoints (CiA 402-2); not yet while it opens a brake.
inline constexpr std::uint16_t kFollowsSetpoints = 0x1000;
/// Homing: home was found.
inline constexpr std::uint16_t kHomingAttained = 0x1000;
/// Homing: it has failed.
inline constexpr std::uint16_t kHomingError = 0x2000;
}  // namespace status_bit

/// State that the master wants an axis to be in.
enum class Goal : std::uint8_t {
  kDisabled,   ///< power off, via Shutdown and Disable voltage
  kEnabled,    ///< Operation enabled, through all states in between
  kQuickStop,  ///< stopped by the drive's own quick stop, then off
};

/// State coded in a status word, without bit 4 (voltage) and bit 7 (warning) (CiA 402-2, masks 4Fh and 6Fh). \rtsafe
[[nodiscard]] AxisState decode_state(std::uint16_t status_word) noexcept;

/// Name as in the standard.
[[nodiscard]] std::string_view to_text(AxisState state) noexcept;
/// "csp", "csv" or "cst", as in line descriptions; "pp", "vl", "pv", "hm" or "ip" for the other modes.
[[nodiscard]] std::string_view to_text(Mode mode) noexcept;

/// The command that brings an axis one state closer to the goal. Never skips a state: drives require the commands one
/// after the other (MSD manual, Table 11.4). In Fault it is Disable voltage: faults are reset on request only. An axis
/// in an unknown state is never switched on; if it is to stop, it gets Quick stop. \rtsafe
[[nodiscard]] std::uint16_t next_control_word(AxisState state, Goal goal) noexcept;

}  // namespace driveline::motion::cia402
