#pragma once

#include <cstdint>

namespace driveline::slaves {

/// Bits of the CiA 402 control word 6040h (IEC 61800-7-201, MSD manual 11.3); some bits are specific to a mode.
namespace control_word {
inline constexpr std::uint16_t kSwitchOn = 0x0001;           ///< bit of the power state machine
inline constexpr std::uint16_t kEnableVoltage = 0x0002;      ///< bit of the power state machine
inline constexpr std::uint16_t kQuickStop = 0x0004;          ///< active low
inline constexpr std::uint16_t kEnableOperation = 0x0008;    ///< bit of the power state machine
inline constexpr std::uint16_t kNewSetpoint = 0x0010;        ///< profile position
inline constexpr std::uint16_t kHomingStart = 0x0010;        ///< homing
inline constexpr std::uint16_t kEnableIp = 0x0010;           ///< interpolated position
inline constexpr std::uint16_t kChangeImmediately = 0x0020;  ///< profile position
inline constexpr std::uint16_t kUnlockRamp = 0x0020;         ///< velocity: 0 freezes the ramp
inline constexpr std::uint16_t kRelative = 0x0040;           ///< profile position
inline constexpr std::uint16_t kReferenceRamp = 0x0040;      ///< velocity: 0 sets the ramp input to zero
inline constexpr std::uint16_t kFaultReset = 0x0080;         ///< rising edge
inline constexpr std::uint16_t kHalt = 0x0100;               ///< stops the axis according to 605Dh; 0: continues
}  // namespace control_word

/// Bits of the CiA 402 status word 6041h (IEC 61800-7-201, MSD manual 11.3); some bits are specific to a mode.
namespace status_word {
inline constexpr std::uint16_t kVoltageEnabled = 0x0010;       ///< the DC link voltage is present
inline constexpr std::uint16_t kWarning = 0x0080;              ///< a limit is nearly exceeded
inline constexpr std::uint16_t kRemote = 0x0200;               ///< the control word of the bus is in use
inline constexpr std::uint16_t kTargetReached = 0x0400;        ///< meaning depends on the mode
inline constexpr std::uint16_t kInternalLimit = 0x0800;        ///< a setpoint is limited by the drive
inline constexpr std::uint16_t kTargetUsed = 0x1000;           ///< CSP, CSV, CST: the setpoint is followed
inline constexpr std::uint16_t kSetpointAcknowledge = 0x1000;  ///< profile position
inline constexpr std::uint16_t kSpeedZero = 0x1000;            ///< profile velocity
inline constexpr std::uint16_t kHomingAttained = 0x1000;       ///< homing
inline constexpr std::uint16_t kIpActive = 0x1000;             ///< interpolated position
inline constexpr std::uint16_t kFollowingError = 0x2000;       ///< profile position, CSP
inline constexpr std::uint16_t kMaxSlippage = 0x2000;          ///< profile velocity
inline constexpr std::uint16_t kHomingError = 0x2000;          ///< homing
inline constexpr std::uint16_t kStandstill = 0x4000;           ///< MSD: ROT_0
inline constexpr std::uint16_t kAxisSynchronised = 0x8000;     ///< MSD
}  // namespace status_word

/// Modes of operation 6060h.
enum class OperationMode : std::int8_t {
  kNone = 0,
  kProfilePosition = 1,
  kVelocity = 2,
  kProfileVelocity = 3,
  kHoming = 6,
  kInterpolatedPosition = 7,
  kCyclicSynchronousPosition = 8,
  kCyclicSynchronousVelocity = 9,
  kCyclicSynchronousTorque = 10,
};

/// Command in bits 0..3 and 7 of the control word (MSD manual Table 11.4). In the table, bit 7 is 0 in every command
/// except the fault reset, so a control word with bit 7 set contains no other command.
enum class PowerCommand : std::uint8_t {
  kNone,
  kDisableVoltage,
  kQuickStop,
  kShutdown,
  kSwitchOn,  ///< in Operation enabled: "disable operation"
  kEnableOperation,
};

/// Returns the command in a control word; kNone with bit 7 set. \rtsafe
[[nodiscard]] constexpr PowerCommand power_command(std::uint16_t word) noexcept {
  using namespace control_word;
  if ((word & kFaultReset) != 0) return PowerCommand::kNone;
  if ((word & kEnableVoltage) == 0) return PowerCommand::kDisableVoltage;
  if ((word & kQuickStop) == 0) return PowerCommand::kQuickStop;
  if ((word & kSwitchOn) == 0) return PowerCommand::kShutdown;
  return (word & kEnableOperation) == 0 ? PowerCommand::kSwitchOn : PowerCommand::kEnableOperation;
}

}  // namespace driveline::slaves
