#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// Elements of an operation datum as a slave sends them, one behind the other.
struct SoeReading {
  wire::SoeElementSet elements;  ///< that are in `data`, in the order of their bits
  std::vector<std::byte> data;   ///< lists, names and units begin with a wire::SoeListHeader
};

/// Elements of an operation datum, each by itself and without the header of lists; nothing: not read, or there is none.
struct SoeParameter {
  std::optional<std::uint16_t> state;            ///< data state; of procedure commands wire::SoeCommandState
  std::optional<std::string> name;               ///< in the drive's language
  std::optional<wire::SoeAttribute> attribute;   ///< length, display, write protection
  std::optional<std::string> unit;               ///< of the shown value
  std::optional<std::vector<std::byte>> min;     ///< as long as the value
  std::optional<std::vector<std::byte>> max;     ///< as long as the value
  std::optional<std::vector<std::byte>> value;   ///< the operation datum itself
  std::optional<std::vector<std::byte>> preset;  ///< its default, as long as the value
};

/// Takes elements apart. The length of minimum, maximum, value and default is that of the attribute in the reading,
/// else of `attribute`; without either only the last element can be one of them. Nothing: the lengths do not add up.
[[nodiscard]] std::optional<SoeParameter> take_apart(const SoeReading& reading,
                                                     std::optional<wire::SoeAttribute> attribute = std::nullopt);

/// The IDNs in a list of them, two bytes each; nothing: an odd number of bytes.
[[nodiscard]] std::optional<std::vector<wire::Idn>> idns_of(std::span<const std::byte> list);

}  // namespace driveline::ecat_master
