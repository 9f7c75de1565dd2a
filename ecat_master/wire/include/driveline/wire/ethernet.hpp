#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"

namespace driveline::wire {

inline constexpr std::uint16_t kEtherTypeEtherCat = 0x88A4;  ///< ETG.1000.4 5.3.2
inline constexpr std::uint16_t kEtherTypeVlan = 0x8100;      ///< IEEE 802.1Q tag
/// EtherType of IPv4, for EtherCAT in UDP.
inline constexpr std::uint16_t kEtherTypeIpv4 = 0x0800;
inline constexpr std::size_t kMinFrameBytes = 60;      ///< shortest Ethernet frame, without FCS
inline constexpr std::size_t kMaxPayloadBytes = 1500;  ///< longest Ethernet payload

/// MAC address in wire order.
using MacAddress = std::array<std::byte, 6>;
/// Broadcast address, the destination of EtherCAT frames.
inline constexpr MacAddress kBroadcastMac{std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF},
                                          std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF}};

/// Ethernet II header (IEEE 802.3), 14 bytes, big endian.
struct EthernetHeader {
  static constexpr std::size_t kSize = 14;  ///< size on the wire, in bytes
  MacAddress destination{};                 ///< ignored by slave controllers
  MacAddress source{};                      ///< the first slave sets its "locally administered" bit
  std::uint16_t ether_type = 0;             ///< in host byte order

  /// Writes the header. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    for (std::size_t i = 0; i < 6; ++i) {
      out[i] = destination[i];
      out[6 + i] = source[i];
    }
    bytes::store_be16(out.subspan<12, 2>(), ether_type);
  }

  /// Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<EthernetHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    EthernetHeader header;
    for (std::size_t i = 0; i < 6; ++i) {
      header.destination[i] = in[i];
      header.source[i] = in[6 + i];
    }
    header.ether_type = bytes::load_be16(in.subspan(12, 2));
    return header;
  }

  constexpr bool operator==(const EthernetHeader&) const = default;
};

}  // namespace driveline::wire
