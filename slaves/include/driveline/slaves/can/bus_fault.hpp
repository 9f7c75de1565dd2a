#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>

#include "driveline/canopen_wire/frame.hpp"

namespace driveline::slaves::can {

/// Kinds of faults of a CAN line. Those that an EtherCAT line has, too, have the same names there.
enum class BusFaultKind : std::uint8_t {
  kDrop,
  kBitError,
  kCableBreak,
  kNoTerminator,
  kBabble,
  kDominant,
  kPowerOff,
  kBitRate,
  kBusOff,
  kReset,
};
/// Number of rows of kBusFaultKinds.
inline constexpr std::size_t kBusFaultKindCount = 10;

/// Parameters of a fault. The values are bits of a BusFaultParameters set.
enum class BusFaultParameter : std::uint16_t {
  kSlave = 0x001,
  kIdentifier = 0x002,
  kMask = 0x004,
  kBit = 0x008,
  kCount = 0x010,
  kChance = 0x020,
  kSeed = 0x040,
  kEnd = 0x080,
  kData = 0x100,
  kRate = 0x200,
};
/// Set of BusFaultParameter bits.
using BusFaultParameters = std::uint16_t;
/// Returns the set of these parameters. \rtsafe
template <typename... Parameters>
[[nodiscard]] constexpr BusFaultParameters bus_fault_parameters(Parameters... parameters) noexcept {
  return static_cast<BusFaultParameters>((0U | ... | static_cast<unsigned>(parameters)));
}
/// \rtsafe
[[nodiscard]] constexpr bool contains(BusFaultParameters set, BusFaultParameter parameter) noexcept {
  return (set & static_cast<unsigned>(parameter)) != 0;
}

/// Ends of the cable.
enum class BusEnd : std::uint8_t { kBoth, kFirst, kLast };

/// A fault of a CAN line and its duration. Only the members that its kind uses have an effect (kBusFaultKinds).
struct BusFault {
  static constexpr std::uint16_t kEverySlave = 0xFFFF;  ///< kDrop: nobody takes the frame

  BusFaultKind kind = BusFaultKind::kDrop;  ///< kind of fault
  std::uint16_t slave = kEverySlave;        ///< place on the line, from 0
  /// Concerned are frames whose identifier agrees with it in the bits of `mask`; kBabble: the identifier that it sends.
  std::uint32_t identifier = 0;
  std::uint32_t mask = 0;               ///< 0: all frames
  std::uint8_t bit = 20;                ///< inverted bit behind the start of frame, stuff bits not counted
  std::uint32_t count = 0;              ///< ends after this number of frames; 0: unlimited
  double chance = 1.0;                  ///< probability that a frame is affected, 0 to 1
  std::uint32_t seed = 1;               ///< seed of the chance
  BusEnd end = BusEnd::kBoth;           ///< end without terminator
  canopen::Frame frame{};               ///< kBabble: length and data
  std::uint32_t bit_rate = 0;           ///< bit/s
  std::chrono::nanoseconds duration{};  ///< ends after this time; 0: lasts until healed

  /// Whether both have the same kind and place, so that only one of them can be active.
  [[nodiscard]] bool same_place(const BusFault& other) const noexcept {
    const bool frames = kind == BusFaultKind::kDrop || kind == BusFaultKind::kBitError;
    return kind == other.kind && slave == other.slave && end == other.end &&
           (!frames || (identifier == other.identifier && mask == other.mask));
  }
};

/// A kind of fault for users: the line description, the command line, the help and the documentation use this table.
struct BusFaultKindRow {
  BusFaultKind kind;         ///< rows are in the order of the enumeration
  std::string_view name;     ///< name in line descriptions and commands; unique
  BusFaultParameters needs;  ///< required parameters
  BusFaultParameters takes;  ///< optional parameters
  bool lasts;                ///< false: an event, which neither lasts nor is healed
  std::string_view text;     ///< description for users
};

namespace bus_fault_detail {
using enum BusFaultParameter;
inline constexpr BusFaultParameters kHits = bus_fault_parameters(kIdentifier, kMask, kCount, kChance, kSeed);
inline constexpr BusFaultParameters kOnlySlave = bus_fault_parameters(kSlave);
}  // namespace bus_fault_detail

/// All kinds, in the order of the enumeration; see bus_fault_kind_row().
inline constexpr std::array<BusFaultKindRow, kBusFaultKindCount> kBusFaultKinds{{
    {BusFaultKind::kDrop, "drop", 0,
     BusFaultParameters{bus_fault_detail::kHits | static_cast<unsigned>(BusFaultParameter::kSlave)}, true,
     "frames are acknowledged, but this slave, or nobody, takes them"},
    {BusFaultKind::kBitError, "bit-error", 0,
     BusFaultParameters{bus_fault_detail::kHits | static_cast<unsigned>(BusFaultParameter::kBit)}, true,
     "a bit of the frames is inverted: an error frame ends them, and they are repeated"},
    {BusFaultKind::kCableBreak, "cable-break", bus_fault_detail::kOnlySlave, 0, true,
     "the cable behind this slave is broken; each piece has the terminator of its own end only"},
    {BusFaultKind::kNoTerminator, "no-terminator", 0, bus_fault_parameters(BusFaultParameter::kEnd), true,
     "the terminators, or that of one end, are missing"},
    {BusFaultKind::kBabble, "babble", bus_fault_detail::kOnlySlave,
     bus_fault_parameters(BusFaultParameter::kIdentifier, BusFaultParameter::kData), true,
     "the slave sends one frame without pause"},
    {BusFaultKind::kDominant, "dominant", bus_fault_detail::kOnlySlave, 0, true,
     "the transceiver of the slave holds the bus dominant"},
    {BusFaultKind::kPowerOff, "power-off", bus_fault_detail::kOnlySlave, 0, true,
     "the slave has no supply; it restarts when the fault is healed"},
    {BusFaultKind::kBitRate, "bit-rate", bus_fault_parameters(BusFaultParameter::kSlave, BusFaultParameter::kRate), 0,
     true, "the slave has another bit rate"},
    {BusFaultKind::kBusOff, "bus-off", bus_fault_detail::kOnlySlave, 0, false,
     "the controller of the slave goes bus off"},
    {BusFaultKind::kReset, "reset", bus_fault_detail::kOnlySlave, 0, false, "the slave is switched off and on again"},
}};

/// A fault parameter for users.
struct BusFaultParameterRow {
  BusFaultParameter parameter;  ///< the parameter of this row
  std::string_view key;         ///< name in line descriptions and commands; unique
  std::string_view value;       ///< expected value, for users
  std::string_view text;        ///< meaning, for users
};

/// All parameters, in the order of their bits.
inline constexpr std::array<BusFaultParameterRow, 10> kBusFaultParameters{{
    {BusFaultParameter::kSlave, "slave", "name or position of a slave", "which slave"},
    {BusFaultParameter::kIdentifier, "id", "0 to 0x1FFFFFFF",
     "identifier of the frames; default: all, and 0 for what babbles"},
    {BusFaultParameter::kMask, "mask", "0 to 0x1FFFFFFF", "bits of id that count; default: all"},
    {BusFaultParameter::kBit, "bit", "1 to 110", "bit behind the start of the frame; default 20"},
    {BusFaultParameter::kCount, "count", "1 to 4294967294",
     "number of frames after which the fault ends; default: no end"},
    {BusFaultParameter::kChance, "chance", "0 to 1", "probability that a frame is affected; default 1"},
    {BusFaultParameter::kSeed, "seed", "0 to 4294967295", "seed of the random numbers for chance; default 1"},
    {BusFaultParameter::kEnd, "end", "both, first or last", "end of the cable; default both"},
    {BusFaultParameter::kData, "data", "up to 16 hexadecimal digits", "data of the frame; default none"},
    {BusFaultParameter::kRate, "rate", "10000 to 1000000", "bit/s, of which 1000000000 is a multiple"},
}};

/// Returns the row of a kind. Precondition: `kind` is one of the enumeration. \rtsafe
[[nodiscard]] constexpr const BusFaultKindRow& bus_fault_kind_row(BusFaultKind kind) noexcept {
  return kBusFaultKinds[static_cast<std::size_t>(kind)];
}

}  // namespace driveline::slaves::can
