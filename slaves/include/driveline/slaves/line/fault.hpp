#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>

#include "driveline/slaves/line/wiring.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"

namespace driveline::slaves {

/// Kinds of faults of a simulated line.
enum class FaultKind : std::uint8_t {
  kDrop,
  kDelay,
  kDuplicate,
  kCorrupt,
  kDamage,
  kShortWorkingCounter,
  kCableBreak,
  kPowerOff,
  kMailboxSilent,
  kMailboxBusy,
  kMailboxMalformed,
  kMailboxOversized,
  kMailboxLate,
  kMailboxForeign,
  kEepromBusy,
  kEepromChecksum,
  kSlowTransition,
  kRefuseTransition,
};
/// Number of rows of kFaultKinds.
inline constexpr std::size_t kFaultKindCount = 18;

/// Parameters of a fault. The values are bits of a FaultParameters set.
enum class FaultParameter : std::uint16_t {
  kSlave = 0x001,
  kPort = 0x002,
  kTo = 0x004,
  kDirection = 0x008,
  kCount = 0x010,
  kChance = 0x020,
  kSeed = 0x040,
  kBits = 0x080,
  kTime = 0x100,
  kState = 0x200,
  kCode = 0x400,
};
/// Set of FaultParameter bits.
using FaultParameters = std::uint16_t;
/// Returns the set of both parameters. \rtsafe
[[nodiscard]] constexpr FaultParameters operator|(FaultParameter a, FaultParameter b) noexcept {
  return static_cast<FaultParameters>(static_cast<unsigned>(a) | static_cast<unsigned>(b));
}
/// Returns the set with one more parameter. \rtsafe
[[nodiscard]] constexpr FaultParameters operator|(FaultParameters a, FaultParameter b) noexcept {
  return static_cast<FaultParameters>(a | static_cast<unsigned>(b));
}
/// \rtsafe
[[nodiscard]] constexpr bool contains(FaultParameters set, FaultParameter parameter) noexcept {
  return (set & static_cast<unsigned>(parameter)) != 0;
}

/// Where a frame is affected.
enum class FaultDirection : std::uint8_t {
  kOut,   ///< before the first slave: no slave receives the frame as sent
  kBack,  ///< after the last slave: all slaves have processed the frame
};

/// A fault and its duration. Only the members that its kind uses have an effect (kFaultKinds). A cable is identified by
/// the slave port that it is connected to.
struct Fault {
  FaultKind kind = FaultKind::kDrop;                                ///< kind of fault
  FaultDirection direction = FaultDirection::kOut;                  ///< where frames are affected; kDrop and kCorrupt
  std::uint16_t slave = 0;                                          ///< position in the line
  std::uint8_t port = 0;                                            ///< 0..3
  std::uint32_t count = 0;                                          ///< ends after this number of frames; 0: unlimited
  double chance = 1.0;                                              ///< probability that a frame is affected, 0..1
  std::uint32_t seed = 1;                                           ///< seed of the chance and of the flipped bits
  std::uint32_t bits = 1;                                           ///< number of flipped bits per frame
  std::chrono::nanoseconds time{0};                                 ///< delay or busy time, depending on the kind
  wire::AlState state = wire::AlState::kOp;                         ///< refused AL state
  wire::AlStatusCode code = wire::AlStatusCode::kUnspecifiedError;  ///< AL status code of the refusal
  std::chrono::nanoseconds duration{0};                             ///< ends after this time; 0: lasts until healed

  /// Whether both have the same kind and place, so that only one of them can be active.
  [[nodiscard]] bool same_place(const Fault& other) const noexcept;
};

/// A kind of fault for users: the line description, the command line, the help and the documentation use this table.
struct FaultKindRow {
  FaultKind kind;         ///< rows are in the order of the enumeration
  std::string_view name;  ///< name in line descriptions and commands; unique
  FaultParameters needs;  ///< required parameters
  FaultParameters takes;  ///< optional parameters
  std::string_view text;  ///< description for users
};

namespace fault_detail {
using enum FaultParameter;
inline constexpr FaultParameters kNone = 0;
inline constexpr FaultParameters kHits = kCount | kChance | kSeed;
inline constexpr FaultParameters kOnlySlave = kNone | kSlave;
}  // namespace fault_detail

/// All kinds, in the order of the enumeration; see fault_kind_row().
inline constexpr std::array<FaultKindRow, kFaultKindCount> kFaultKinds{{
    {FaultKind::kDrop, "drop", 0, fault_detail::kHits | FaultParameter::kDirection, "frames get lost"},
    {FaultKind::kDelay, "delay", fault_detail::kNone | FaultParameter::kTime, fault_detail::kHits,
     "frames come back late; the frames after them wait"},
    {FaultKind::kDuplicate, "duplicate", 0, fault_detail::kHits, "frames come back twice"},
    {FaultKind::kCorrupt, "corrupt", 0,
     FaultParameters{fault_detail::kHits | FaultParameter::kDirection} | FaultParameter::kBits,
     "bits after the Ethernet header flip without an error indication"},
    {FaultKind::kDamage, "damage", FaultParameter::kSlave | FaultParameter::kPort, fault_detail::kHits,
     "frames that come in at this port have a wrong check sequence: counted by the slaves (0300h, 0308h), ignored by "
     "the slaves after it, discarded by the master's interface"},
    {FaultKind::kShortWorkingCounter, "short-wkc", fault_detail::kOnlySlave, fault_detail::kHits,
     "the slave takes no part in LRD, LWR and LRW"},
    {FaultKind::kCableBreak, "cable-break", fault_detail::kOnlySlave, FaultParameter::kPort | FaultParameter::kTo,
     "the cable at this port, or to that slave, is broken"},
    {FaultKind::kPowerOff, "power-off", fault_detail::kOnlySlave, 0,
     "the slave has no supply; it restarts when the fault is healed"},
    {FaultKind::kMailboxSilent, "mailbox-silent", fault_detail::kOnlySlave, 0,
     "the slave takes mailbox requests and never replies"},
    {FaultKind::kMailboxBusy, "mailbox-busy", fault_detail::kOnlySlave, 0,
     "the slave does not empty its mailbox: the next request finds it full"},
    {FaultKind::kMailboxMalformed, "mailbox-malformed", fault_detail::kOnlySlave, 0,
     "mailbox messages of the slave end after the third byte of their service data"},
    {FaultKind::kMailboxOversized, "mailbox-oversized", fault_detail::kOnlySlave, 0,
     "mailbox messages of the slave announce more bytes than the mailbox holds"},
    {FaultKind::kMailboxLate, "mailbox-late", FaultParameter::kSlave | FaultParameter::kTime, 0,
     "mailbox messages of the slave are delayed by this time"},
    {FaultKind::kMailboxForeign, "mailbox-foreign", fault_detail::kOnlySlave, 0,
     "before each mailbox message the slave sends one of an unknown protocol"},
    {FaultKind::kEepromBusy, "eeprom-busy", FaultParameter::kSlave | FaultParameter::kTime, 0,
     "every EEPROM command takes this long"},
    {FaultKind::kEepromChecksum, "eeprom-checksum", fault_detail::kOnlySlave, 0,
     "the configuration area has a wrong checksum; the slave detects it when it loads the area: at a reload command or "
     "the next power-on"},
    {FaultKind::kSlowTransition, "slow-transition", FaultParameter::kSlave | FaultParameter::kTime, 0,
     "the slave takes this long for every change of its AL state"},
    {FaultKind::kRefuseTransition, "refuse-transition", FaultParameter::kSlave | FaultParameter::kState,
     fault_detail::kNone | FaultParameter::kCode, "the slave refuses this AL state with that AL status code"},
}};

/// A fault parameter for users.
struct FaultParameterRow {
  FaultParameter parameter;  ///< the parameter of this row
  std::string_view key;      ///< name in line descriptions and commands; unique
  std::string_view value;    ///< expected value, for users
  std::string_view text;     ///< meaning, for users
};

/// All parameters, in the order of their bits.
inline constexpr std::array<FaultParameterRow, 11> kFaultParameters{{
    {FaultParameter::kSlave, "slave", "name or position of a slave", "which slave"},
    {FaultParameter::kPort, "port", "0 to 3", "port of the slave"},
    {FaultParameter::kTo, "to", "name or position of a slave", "the slave at the other end of the cable"},
    {FaultParameter::kDirection, "way", "out or back", "before the first slave (default) or after the last slave"},
    {FaultParameter::kCount, "count", "1 to 4294967295",
     "number of frames after which the fault ends; default: no end"},
    {FaultParameter::kChance, "chance", "0 to 1", "probability that a frame is affected; default 1"},
    {FaultParameter::kSeed, "seed", "0 to 4294967295",
     "seed of the random numbers for chance and flipped bits; default 1"},
    {FaultParameter::kBits, "bits", "1 to 1000", "number of bits flipped per frame; default 1"},
    {FaultParameter::kTime, "time_us", "1 to 60000000", "us"},
    {FaultParameter::kState, "state", "INIT, PREOP, BOOT, SAFEOP or OP", "the AL state that is refused"},
    {FaultParameter::kCode, "code", "0 to 65535", "AL status code; default 1"},
}};

/// Returns the row of a kind. Precondition: `kind` is one of the enumeration. \rtsafe
[[nodiscard]] constexpr const FaultKindRow& fault_kind_row(FaultKind kind) noexcept {
  return kFaultKinds[static_cast<std::size_t>(kind)];
}

}  // namespace driveline::slaves
