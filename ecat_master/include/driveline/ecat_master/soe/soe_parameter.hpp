#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// Elements of an operation datum as sent by a slave, concatenated.
struct SoeReading {
  wire::SoeElementSet elements;  ///< elements in `data`, in bit order
  std::vector<std::byte> data;   ///< raw data; lists, names and units start with a wire::SoeListHeader
};

/// Decoded elements of an operation datum, without list headers; empty: not read, or not present.
struct SoeParameter {
  std::optional<std::uint16_t> state;            ///< data state; for procedure commands wire::SoeCommandState
  std::optional<std::string> name;               ///< in the drive's language
  std::optional<wire::SoeAttribute> attribute;   ///< length, display, write protection
  std::optional<std::string> unit;               ///< unit of the displayed value
  std::optional<std::vector<std::byte>> min;     ///< minimum, as long as the value
  std::optional<std::vector<std::byte>> max;     ///< maximum, as long as the value
  std::optional<std::vector<std::byte>> value;   ///< the value
  std::optional<std::vector<std::byte>> preset;  ///< default value, as long as the value
};

/// Decodes the elements. The length of minimum, maximum, value and default comes from the attribute in the reading,
/// else from `attribute`; without either, only the last element can be one of them. Empty: the lengths do not match.
[[nodiscard]] std::optional<SoeParameter> decode_parameter(const SoeReading& reading,
                                                           std::optional<wire::SoeAttribute> attribute = std::nullopt);

/// Decodes a list of IDNs, two bytes each; empty: an odd number of bytes.
[[nodiscard]] std::optional<std::vector<wire::Idn>> idns_of(std::span<const std::byte> list);

}  // namespace driveline::ecat_master
