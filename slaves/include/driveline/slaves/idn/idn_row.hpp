#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "driveline/slaves/od/slot.hpp"
#include "driveline/wire/soe.hpp"

/// Row of a drive's table of operation data (SERCOS, IEC 61800-7-204): all properties of an IDN.
namespace driveline::slaves {

/// Type of the slots whose values are lists and texts.
struct IdnList {};

/// A procedure command: its value, and the data state that it has because of it.
struct IdnCommand {
  std::uint16_t order = wire::kSoeCommandCancel;                 ///< value that the master wrote last
  wire::SoeCommandState state = wire::SoeCommandState::kNotSet;  ///< data state, element 1
  [[nodiscard]] constexpr bool operator==(const IdnCommand&) const = default;
};

/// Lists whose content follows from the rows of the table, in ascending order of the raw numbers.
enum class IdnSelection : std::uint8_t {
  kNone,      ///< the list has a content of its own
  kAll,       ///< every row: S-0-0017
  kCommands,  ///< procedure commands: S-0-0025
  kAt,        ///< data that the AT may carry: S-0-0187
  kMdt,       ///< data that the MDT may carry: S-0-0188
  kSaved,     ///< data that the drive saves: S-0-0192
};

/// Uses of an IDN, as bits.
namespace idn_use {
inline constexpr std::uint8_t kNone = 0;
inline constexpr std::uint8_t kAt = 1;      ///< the AT may carry it
inline constexpr std::uint8_t kMdt = 2;     ///< the MDT may carry it
inline constexpr std::uint8_t kSaved = 4;   ///< S-0-0264 saves it
inline constexpr std::uint8_t kStored = 8;  ///< the drive keeps the value, which has no effect
}  // namespace idn_use

/// Row of a table of operation data. Numbers have at most 32 bits, so they are exact in a double.
struct IdnRow {
  /// The table assigns a separate slot to the row.
  static constexpr std::uint16_t kOwnSlot = 0xFFFF;

  wire::Idn idn;                   ///< number; only parameter set 0 exists
  std::string_view name{};         ///< element 2; empty: none
  wire::SoeAttribute attribute{};  ///< element 3: length, display, decimals, protection in each phase
  std::string_view unit{};         ///< element 4; empty: none. Weighted: POS, SPEED, ACC, TORQUE or TEMP
  double initial = 0.0;            ///< value after power-on when none is saved; 0 for a list
  double minimum = -std::numeric_limits<double>::infinity();  ///< element 5; infinite: none
  double maximum = std::numeric_limits<double>::infinity();   ///< element 6; infinite: none
  bool has_default = false;                                   ///< whether element 8 is there: `initial`
  std::uint16_t capacity = 0;                                 ///< maximum size of a list in bytes
  std::string_view text{};                                    ///< content of a text after power-on
  std::span<const std::uint16_t> elements{};                  ///< content of a list of 2-byte elements after power-on
  IdnSelection selection = IdnSelection::kNone;               ///< content that follows from the table
  std::uint16_t slot = kOwnSlot;                              ///< number of the value; equal: one value, two IDNs
  std::uint8_t uses = idn_use::kNone;                         ///< bits of namespace idn_use
  std::uint16_t line = 0;     ///< line of the manual with number, name, unit and protection; 0: none
  std::string_view source{};  ///< where type, length, limits and default are from; "ours" marks what no source states
};

/// Whether the value is one number, not a list and not a procedure command. \rtsafe
[[nodiscard]] constexpr bool is_number(const IdnRow& row) noexcept {
  return !row.attribute.list && !row.attribute.command;
}

/// Whether no phase allows a write. \rtsafe
[[nodiscard]] constexpr bool is_read_only(const wire::SoeAttribute& attribute) noexcept {
  return attribute.pre_op_protected && attribute.safe_op_protected && attribute.op_protected;
}

/// Whether values of type T are the values of a row with this attribute.
template <typename T>
[[nodiscard]] constexpr bool is_value_of(const wire::SoeAttribute& attribute) noexcept {
  if constexpr (std::is_same_v<T, IdnList>) return attribute.list;
  if constexpr (std::is_same_v<T, IdnCommand>) return attribute.command;
  if constexpr (std::is_arithmetic_v<T>) {
    return !attribute.list && !attribute.command && attribute.element_size() == sizeof(T) &&
           (attribute.display == wire::SoeDisplay::kSigned) ==
               (std::is_signed_v<T> && std::is_integral_v<T>)&&(attribute.display == wire::SoeDisplay::kFloat) ==
               std::is_floating_point_v<T>;
  }
  return false;
}

/// Returns the row with its value in a named slot. Does not compile in a constant table if the types differ.
template <typename T>
[[nodiscard]] constexpr IdnRow in_slot(Slot<T> slot, IdnRow row) {
  if (!is_value_of<T>(row.attribute)) throw std::logic_error("the slot has another type than the row");
  row.slot = slot.number;
  return row;
}

}  // namespace driveline::slaves
