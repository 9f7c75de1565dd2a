#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace driveline::wire {

/// AL status codes, register 0x0134 (ETG.1000.6 Table 11, ETG.1020 Table 27). Other values may arrive and are retained.
enum class AlStatusCode : std::uint16_t {
  kNoError = 0x0000,
  kUnspecifiedError = 0x0001,
  kNoMemory = 0x0002,
  kInvalidDeviceSetup = 0x0003,
  kInvalidRevision = 0x0004,
  kSiiEepromMismatch = 0x0006,
  kFirmwareUpdateFailed = 0x0007,
  kLicenseError = 0x000E,
  kInvalidRequestedStateChange = 0x0011,
  kUnknownRequestedState = 0x0012,
  kBootstrapNotSupported = 0x0013,
  kNoValidFirmware = 0x0014,
  kInvalidMailboxConfigurationBoot = 0x0015,
  kInvalidMailboxConfigurationPreOp = 0x0016,
  kInvalidSyncManagerConfiguration = 0x0017,
  kNoValidInputs = 0x0018,
  kNoValidOutputs = 0x0019,
  kSynchronizationError = 0x001A,
  kSyncManagerWatchdog = 0x001B,
  kInvalidSyncManagerTypes = 0x001C,
  kInvalidOutputConfiguration = 0x001D,
  kInvalidInputConfiguration = 0x001E,
  kInvalidWatchdogConfiguration = 0x001F,
  kNeedsColdStart = 0x0020,
  kNeedsInit = 0x0021,
  kNeedsPreOp = 0x0022,
  kNeedsSafeOp = 0x0023,
  kInvalidInputMapping = 0x0024,
  kInvalidOutputMapping = 0x0025,
  kInconsistentSettings = 0x0026,
  kFreeRunNotSupported = 0x0027,
  kSyncModeNotSupported = 0x0028,
  kFreeRunNeedsThreeBufferMode = 0x0029,
  kBackgroundWatchdog = 0x002A,
  kNoValidInputsAndOutputs = 0x002B,
  kFatalSyncError = 0x002C,
  kNoSyncError = 0x002D,
  kCycleTimeTooSmall = 0x002E,
  kInvalidDcSyncConfiguration = 0x0030,
  kInvalidDcLatchConfiguration = 0x0031,
  kPllError = 0x0032,
  kDcSyncIoError = 0x0033,
  kDcSyncTimeout = 0x0034,
  kDcInvalidSyncCycleTime = 0x0035,
  kDcSync0CycleTime = 0x0036,
  kDcSync1CycleTime = 0x0037,
  kMailboxAoe = 0x0041,
  kMailboxEoe = 0x0042,
  kMailboxCoe = 0x0043,
  kMailboxFoe = 0x0044,
  kMailboxSoe = 0x0045,
  kMailboxVoe = 0x004F,
  kEepromNoAccess = 0x0050,
  kEepromError = 0x0051,
  kExternalHardwareNotReady = 0x0052,
  kSlaveRestartedLocally = 0x0060,
  kDeviceIdentificationUpdated = 0x0061,
  kApplicationControllerAvailable = 0x00F0,
};

/// A code and its text.
struct AlStatusCodeText {
  AlStatusCode code;
  std::string_view text;  ///< its meaning in the words of ETG.1020
};

/// Every code of the standard with its meaning, ascending.
inline constexpr std::array kAlStatusCodeTexts = {
    AlStatusCodeText{AlStatusCode::kNoError, "no error"},
    AlStatusCodeText{AlStatusCode::kUnspecifiedError, "unspecified error"},
    AlStatusCodeText{AlStatusCode::kNoMemory, "no memory"},
    AlStatusCodeText{AlStatusCode::kInvalidDeviceSetup, "invalid device setup"},
    AlStatusCodeText{AlStatusCode::kInvalidRevision, "invalid revision"},
    AlStatusCodeText{AlStatusCode::kSiiEepromMismatch, "SII/EEPROM information does not match the firmware"},
    AlStatusCodeText{AlStatusCode::kFirmwareUpdateFailed, "firmware update not successful"},
    AlStatusCodeText{AlStatusCode::kLicenseError, "licence error"},
    AlStatusCodeText{AlStatusCode::kInvalidRequestedStateChange, "invalid requested state change"},
    AlStatusCodeText{AlStatusCode::kUnknownRequestedState, "unknown requested state"},
    AlStatusCodeText{AlStatusCode::kBootstrapNotSupported, "bootstrap not supported"},
    AlStatusCodeText{AlStatusCode::kNoValidFirmware, "no valid firmware"},
    AlStatusCodeText{AlStatusCode::kInvalidMailboxConfigurationBoot, "invalid mailbox configuration (bootstrap)"},
    AlStatusCodeText{AlStatusCode::kInvalidMailboxConfigurationPreOp, "invalid mailbox configuration (PREOP)"},
    AlStatusCodeText{AlStatusCode::kInvalidSyncManagerConfiguration, "invalid sync manager configuration"},
    AlStatusCodeText{AlStatusCode::kNoValidInputs, "no valid inputs available"},
    AlStatusCodeText{AlStatusCode::kNoValidOutputs, "no valid outputs"},
    AlStatusCodeText{AlStatusCode::kSynchronizationError, "synchronization error"},
    AlStatusCodeText{AlStatusCode::kSyncManagerWatchdog, "sync manager watchdog"},
    AlStatusCodeText{AlStatusCode::kInvalidSyncManagerTypes, "invalid sync manager types"},
    AlStatusCodeText{AlStatusCode::kInvalidOutputConfiguration, "invalid output configuration"},
    AlStatusCodeText{AlStatusCode::kInvalidInputConfiguration, "invalid input configuration"},
    AlStatusCodeText{AlStatusCode::kInvalidWatchdogConfiguration, "invalid watchdog configuration"},
    AlStatusCodeText{AlStatusCode::kNeedsColdStart, "slave needs cold start"},
    AlStatusCodeText{AlStatusCode::kNeedsInit, "slave needs INIT"},
    AlStatusCodeText{AlStatusCode::kNeedsPreOp, "slave needs PREOP"},
    AlStatusCodeText{AlStatusCode::kNeedsSafeOp, "slave needs SAFEOP"},
    AlStatusCodeText{AlStatusCode::kInvalidInputMapping, "invalid input mapping"},
    AlStatusCodeText{AlStatusCode::kInvalidOutputMapping, "invalid output mapping"},
    AlStatusCodeText{AlStatusCode::kInconsistentSettings, "inconsistent settings"},
    AlStatusCodeText{AlStatusCode::kFreeRunNotSupported, "free run not supported"},
    AlStatusCodeText{AlStatusCode::kSyncModeNotSupported, "synchronization mode not supported"},
    AlStatusCodeText{AlStatusCode::kFreeRunNeedsThreeBufferMode, "free run needs three-buffer mode"},
    AlStatusCodeText{AlStatusCode::kBackgroundWatchdog, "background watchdog"},
    AlStatusCodeText{AlStatusCode::kNoValidInputsAndOutputs, "no valid inputs and outputs"},
    AlStatusCodeText{AlStatusCode::kFatalSyncError, "fatal synchronization error"},
    AlStatusCodeText{AlStatusCode::kNoSyncError, "no synchronization signal"},
    AlStatusCodeText{AlStatusCode::kCycleTimeTooSmall, "cycle time too small"},
    AlStatusCodeText{AlStatusCode::kInvalidDcSyncConfiguration, "invalid DC SYNC configuration"},
    AlStatusCodeText{AlStatusCode::kInvalidDcLatchConfiguration, "invalid DC latch configuration"},
    AlStatusCodeText{AlStatusCode::kPllError, "PLL error"},
    AlStatusCodeText{AlStatusCode::kDcSyncIoError, "DC sync I/O error"},
    AlStatusCodeText{AlStatusCode::kDcSyncTimeout, "DC sync timeout"},
    AlStatusCodeText{AlStatusCode::kDcInvalidSyncCycleTime, "invalid DC sync cycle time"},
    AlStatusCodeText{AlStatusCode::kDcSync0CycleTime, "DC SYNC0 cycle time does not fit"},
    AlStatusCodeText{AlStatusCode::kDcSync1CycleTime, "DC SYNC1 cycle time does not fit"},
    AlStatusCodeText{AlStatusCode::kMailboxAoe, "AoE mailbox error"},
    AlStatusCodeText{AlStatusCode::kMailboxEoe, "EoE mailbox error"},
    AlStatusCodeText{AlStatusCode::kMailboxCoe, "CoE mailbox error"},
    AlStatusCodeText{AlStatusCode::kMailboxFoe, "FoE mailbox error"},
    AlStatusCodeText{AlStatusCode::kMailboxSoe, "SoE mailbox error"},
    AlStatusCodeText{AlStatusCode::kMailboxVoe, "VoE mailbox error"},
    AlStatusCodeText{AlStatusCode::kEepromNoAccess, "EEPROM not assigned to the application"},
    AlStatusCodeText{AlStatusCode::kEepromError, "EEPROM access error"},
    AlStatusCodeText{AlStatusCode::kExternalHardwareNotReady, "external hardware not ready"},
    AlStatusCodeText{AlStatusCode::kSlaveRestartedLocally, "slave restarted locally"},
    AlStatusCodeText{AlStatusCode::kDeviceIdentificationUpdated, "device identification value updated"},
    AlStatusCodeText{AlStatusCode::kApplicationControllerAvailable, "application controller available"},
};

/// Meaning of a code; "vendor specific" from 0x8000, "unknown code" otherwise.
[[nodiscard]] constexpr std::string_view to_text(AlStatusCode code) noexcept {
  const auto* found = std::lower_bound(kAlStatusCodeTexts.begin(), kAlStatusCodeTexts.end(), code,
                                       [](const AlStatusCodeText& row, AlStatusCode c) { return row.code < c; });
  if (found != kAlStatusCodeTexts.end() && found->code == code) return found->text;
  return static_cast<std::uint16_t>(code) >= 0x8000 ? "vendor specific" : "unknown code";
}

}  // namespace driveline::wire
