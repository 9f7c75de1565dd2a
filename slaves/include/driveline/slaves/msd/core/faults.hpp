#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Faults of the drive that the model can have.
enum class Fault : std::uint8_t {
  kBusWatchdog,
  kInvalidConfiguration,
  kMissingOutputs,
  kLocalError,
  kFollowingError,
  kDcLinkUndervoltage,
  kPositiveLimitSwitch,
  kNegativeLimitSwitch,
  kHoming,
  kOvercurrent,
  kDcLinkOvervoltage,
  kMotorOverload,
  kMotorTemperature,
  kAmplifierTemperature,
  kEncoder,
  kEepromData,
  kInternalRam,
  kParameterList,
  kBusOff,
  kLifeGuarding,
  kHeartbeat,
  kTelegramFailure,
  kCommunicationEnded,
  kCount,
};

/// Properties of a fault, from the manual.
struct FaultFacts {
  Fault fault = Fault::kLocalError;  ///< rows are in the order of the enumeration
  std::uint8_t number = 0;           ///< error number, first two digits on the display
  std::uint8_t location = 0;         ///< error location, second two digits
  std::uint16_t error_code = 0;      ///< CiA 402 code of 603Fh and of the emergency
  std::uint8_t error_register = 0;   ///< bits of 1001h in addition to bit 0
  bool coast = false;                ///< no fault reaction but switching off
  std::string_view text;             ///< text for users, without numbers
  std::string_view source;           ///< source of the numbers; "ours" marks numbers that no source states
};

/// Source of faults of a bus for which the manual gives the code only.
inline constexpr std::string_view kFieldBusSource = "MSD manual 13.1 (FF00h); number, location, register bit ours";

/// All faults: the only place to correct numbers that no manual states.
inline constexpr std::array kFaults = {
    FaultFacts{Fault::kBusWatchdog, 14, 1, 0xFF00, 0x10, false, "EtherCAT watchdog",
               "MSD manual 5.6, 13.1 (FF00h); register bit ours"},
    FaultFacts{Fault::kInvalidConfiguration, 14, 4, 0xFF00, 0x10, false, "invalid configuration",
               "MSD manual 5.6, 13.1 (FF00h); register bit ours"},
    FaultFacts{Fault::kMissingOutputs, 14, 5, 0xFF00, 0x10, false, "process data on sync manager 2 stopped",
               "MSD manual 5.6, 13.1 (FF00h); register bit ours"},
    FaultFacts{Fault::kLocalError, 14, 6, 0xFF00, 0x10, false, "local error: the slave left OP by itself",
               "MSD manual 5.6, 13.1 (FF00h); register bit ours"},
    FaultFacts{Fault::kFollowingError, 17, 1, 0x8611, 0x20, false, "following error too large",
               "Device Help 11.6.18 (error 17), code CiA 402; location ours"},
    FaultFacts{Fault::kDcLinkUndervoltage, 5, 1, 0x3220, 0x04, true, "DC link undervoltage",
               "code CiA 402; number and location ours"},
    FaultFacts{Fault::kPositiveLimitSwitch, 8, 1, 0x8612, 0x20, false, "positive limit switch",
               "code CiA 402 (reference limit); number and location ours"},
    FaultFacts{Fault::kNegativeLimitSwitch, 8, 2, 0x8612, 0x20, false, "negative limit switch",
               "code CiA 402 (reference limit); number and location ours"},
    FaultFacts{Fault::kHoming, 20, 1, 0x8600, 0x20, false, "homing failed",
               "MSD manual Table 12.14: an error code tells the cause; numbers ours"},
    FaultFacts{Fault::kOvercurrent, 3, 1, 0x2310, 0x02, true, "overcurrent", "code CiA 402; number and location ours"},
    FaultFacts{Fault::kDcLinkOvervoltage, 4, 1, 0x3210, 0x04, true, "DC link overvoltage",
               "code CiA 402; number and location ours"},
    FaultFacts{Fault::kMotorOverload, 9, 1, 0x2350, 0x02, false, "motor I2t integrator over its limit",
               "Device Help: E-09-01; code CiA 402"},
    FaultFacts{Fault::kMotorTemperature, 6, 1, 0x4310, 0x08, false, "motor too hot",
               "code CiA 402; number and location ours"},
    FaultFacts{Fault::kAmplifierTemperature, 7, 1, 0x4210, 0x08, false, "power stage too hot",
               "code CiA 402; number and location ours"},
    FaultFacts{Fault::kEncoder, 10, 1, 0x7300, 0x20, true, "encoder", "code CiA 402; number and location ours"},
    FaultFacts{Fault::kEepromData, 14, 2, 0xFF00, 0x10, true, "wrong EEPROM data or communication controller",
               "MSD manual 5.3.3, 13.1 (FF00h); register bit ours"},
    FaultFacts{Fault::kInternalRam, 14, 3, 0xFF00, 0x10, true, "internal RAM error",
               "MSD manual 5.3.3, 13.1 (FF00h); register bit ours"},
    FaultFacts{Fault::kParameterList, 2, 5, 0x6320, 0x20, true, "actual values of the parameter list",
               "MSD manual 4.7; code CiA 402 (parameter error)"},
    FaultFacts{Fault::kBusOff, 12, 1, 0xFF00, 0x10, false, "bus off", kFieldBusSource},
    FaultFacts{Fault::kLifeGuarding, 12, 2, 0xFF00, 0x10, false, "no guarding by the master", kFieldBusSource},
    FaultFacts{Fault::kHeartbeat, 12, 3, 0xFF00, 0x10, false, "no heartbeat of the master", kFieldBusSource},
    FaultFacts{Fault::kTelegramFailure, 12, 4, 0xFF00, 0x10, false, "telegram failure", kFieldBusSource},
    FaultFacts{Fault::kCommunicationEnded, 12, 5, 0xFF00, 0x10, false, "communication ended with the power on",
               kFieldBusSource},
};

/// Warnings: bits of P 34 (classes of the SERCOS manual, S-0-0012; numbers from there, texts ours).
enum class Warning : std::uint8_t {
  kOverload = 0,
  kAmplifierTemperature = 1,
  kMotorTemperature = 2,
  kDcLinkUndervoltage = 9,
};
/// Returns a text for users; never empty. \rtsafe
[[nodiscard]] std::string_view text(Warning warning) noexcept;

/// Returns the properties of a fault. Precondition: not kCount. \rtsafe
[[nodiscard]] constexpr const FaultFacts& facts(Fault fault) noexcept {
  return kFaults[static_cast<std::size_t>(fault)];
}

/// Maximum operating hours in a message to the master: three bytes.
inline constexpr std::uint32_t kMaxOperatingHours = 0xFFFFFF;

/// Message to the master about a fault (MSD manual 13.1); all 0: the fault was acknowledged (Table 13.2).
struct FaultMessage {
  std::uint16_t error_code = 0;       ///< 603Fh
  std::uint8_t error_register = 0;    ///< 1001h
  std::uint8_t number = 0;            ///< FaultFacts::number
  std::uint8_t location = 0;          ///< FaultFacts::location
  std::uint32_t operating_hours = 0;  ///< complete hours, at most kMaxOperatingHours
};

/// The fault that is active until it is acknowledged, and its objects 603Fh, 1001h, 1003h, P 33[0].
class FaultRecord {
 public:
  /// The dictionary must outlive this.
  explicit FaultRecord(ObjectDictionary& dictionary) noexcept;

  /// Returns the active fault; nullopt: none. \rtsafe
  [[nodiscard]] std::optional<Fault> standing() const noexcept { return fault_; }
  /// Enters a fault and returns its message. \rtsafe
  [[nodiscard]] FaultMessage enter(Fault fault, std::uint32_t operating_hours) noexcept;
  /// Removes the fault and returns the message about it. \rtsafe
  [[nodiscard]] FaultMessage acknowledge() noexcept;
  /// Power-on: the dictionary has its initial values. \rtsafe
  void reset() noexcept { fault_.reset(); }

 private:
  ObjectDictionary* dictionary_;
  std::uint16_t text_slot_;  ///< text slot of P 33[0]
  std::optional<Fault> fault_;
};

}  // namespace driveline::slaves::msd
