#pragma once

#include <cstdint>
#include <optional>

#include "driveline/slaves/cia402/power_state_machine.hpp"

namespace driveline::slaves::msd {

/// Bits of the master control word S-0-0134 (ServoOne SERCOS manual, Table 4.1). Bits 10 and 12 have no effect; bits 5
/// to 0 belong to the service channel of the ring.
namespace master_control {
inline constexpr std::uint16_t kOn = 0x8000;      ///< controller enable
inline constexpr std::uint16_t kEnable = 0x4000;  ///< power stage enable
inline constexpr std::uint16_t kStart = 0x2000;   ///< 0: drive halt
/// Real-time control bits 1 and 2.
inline constexpr std::uint16_t kRealTime[] = {0x0040, 0x0080};
/// All three: the drive is to follow its setpoints (line 423).
inline constexpr std::uint16_t kFollow = kOn | kEnable | kStart;

/// Returns which of S-0-0032 to S-0-0035 bits 11, 9 and 8 choose; nullopt: none of them (lines 435-443). \rtsafe
[[nodiscard]] constexpr std::optional<std::uint8_t> mode(std::uint16_t word) noexcept {
  if ((word & 0x0800U) != 0) return std::nullopt;
  return static_cast<std::uint8_t>(word >> 8U & 3U);
}
}  // namespace master_control

/// Bits of the drive status word S-0-0135 (ServoOne SERCOS manual, Tables 4.2 and 4.3). Bits 2 to 0 belong to the
/// service channel of the ring.
namespace drive_status {
inline constexpr std::uint16_t kReady = 0xC000;                 ///< both bits: in control; kPowerOff, kNoPower
inline constexpr std::uint16_t kPowerOff = 0x8000;              ///< power is there, the drive is free of torque
inline constexpr std::uint16_t kNoPower = 0x4000;               ///< ready for the power to come
inline constexpr std::uint16_t kLocked = 0x2000;                ///< a fault of class 1
inline constexpr std::uint16_t kClass2 = 0x1000;                ///< C2D has changed
inline constexpr std::uint16_t kClass3 = 0x0800;                ///< C3D has changed
inline constexpr unsigned kModeShift = 8;                       ///< bits 10 to 8: mode in force, 0 to 3
inline constexpr std::uint16_t kRealTime[] = {0x0040, 0x0080};  ///< real-time status bits 1 and 2
inline constexpr std::uint16_t kCommandChange = 0x0020;         ///< a procedure command has ended
inline constexpr std::uint16_t kFollows = 0x0008;               ///< the drive follows the setpoints of the master

/// Returns bits 15 to 13 in a state (Table 4.3). `dc_link`: the DC link voltage is present. \rtsafe
[[nodiscard]] constexpr std::uint16_t of(PowerState state, bool dc_link) noexcept {
  switch (state) {
    case PowerState::kNotReadyToSwitchOn:
      return 0;
    case PowerState::kSwitchOnDisabled:
      return dc_link ? kPowerOff : kNoPower;
    case PowerState::kReadyToSwitchOn:
    case PowerState::kSwitchedOn:
      return kPowerOff;
    case PowerState::kOperationEnabled:
    case PowerState::kQuickStopActive:
      return kReady;
    case PowerState::kFaultReactionActive:
      return kReady | kLocked;
    case PowerState::kFault:
      return kLocked;
  }
  return 0;
}
}  // namespace drive_status

/// Bits of the interface status S-0-0014 (line 792).
namespace interface_status {
inline constexpr std::uint16_t kModeNotSetUp = 0x0200;  ///< a mode was chosen that is not set up
}  // namespace interface_status

/// Bits of the positioning control word S-0-0346 (lines 995-1006).
namespace positioning {
inline constexpr std::uint16_t kTake = 0x0001;         ///< its rise takes S-0-0282
inline constexpr std::uint16_t kMotion = 0x0006;       ///< kJogPositive, kJogNegative, kHalt; 0: to positions
inline constexpr std::uint16_t kJogPositive = 0x0002;  ///< value of kMotion
inline constexpr std::uint16_t kJogNegative = 0x0004;  ///< value of kMotion
inline constexpr std::uint16_t kHalt = 0x0006;         ///< value of kMotion
inline constexpr std::uint16_t kRelative = 0x0008;     ///< S-0-0282 is a distance
inline constexpr std::uint16_t kFromActual = 0x0010;   ///< the distance begins at the actual position
}  // namespace positioning

}  // namespace driveline::slaves::msd
