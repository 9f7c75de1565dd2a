#pragma once

#include <cstdint>
#include <string_view>
#include <tl/expected.hpp>

namespace driveline::wire {

/// Why bytes from the wire were not accepted.
enum class DecodeError : std::uint8_t {
  kTooShort,      ///< fewer bytes than the structure needs
  kBadLength,     ///< a length field exceeds the available bytes
  kNotEtherCat,   ///< neither EtherType 0x88A4 nor EtherCAT in UDP
  kNotCommands,   ///< EtherCAT type other than 1 (datagrams)
  kBadService,    ///< the service or type field does not fit the expected structure
  kReservedBits,  ///< bits that must be zero are set
};

/// Text of a DecodeError for messages.
[[nodiscard]] constexpr std::string_view to_text(DecodeError error) noexcept {
  switch (error) {
    case DecodeError::kTooShort:
      return "shorter than its header says";
    case DecodeError::kBadLength:
      return "length field exceeds the data";
    case DecodeError::kNotEtherCat:
      return "not an EtherCAT frame";
    case DecodeError::kNotCommands:
      return "EtherCAT frame without datagrams";
    case DecodeError::kBadService:
      return "unexpected service";
    case DecodeError::kReservedBits:
      return "reserved bits set";
  }
  return "undecodable";
}

template <typename T>
/// Result of decoding: the structure, or why the bytes do not form one.
using Decoded = tl::expected<T, DecodeError>;

}  // namespace driveline::wire
