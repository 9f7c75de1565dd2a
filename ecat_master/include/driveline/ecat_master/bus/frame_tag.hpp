#pragma once

#include <cstdint>

#include "driveline/wire/ethernet.hpp"

namespace driveline::ecat_master {

/// The identity of a frame, carried in its Ethernet source address.
///
/// The 8-bit datagram index comes round after 256 frames, 32 ms at 8 kHz, so a late frame could be taken for a new
/// one. Slave controllers do not look at the source address; the first one only sets the "locally administered" bit
/// in its first byte (ESC data sheet I, "Ethernet frame processing"). The master therefore numbers its frames there:
/// byte 0 is zero, byte 1 tells two masters on one wire apart, bytes 2-5 are a sequence number that lasts for days.
struct FrameTag {
  std::uint8_t instance = 0;
  std::uint32_t sequence = 0;

  [[nodiscard]] constexpr wire::MacAddress to_mac() const noexcept {
    wire::MacAddress mac{};
    mac[1] = static_cast<std::byte>(instance);
    wire::store_le(std::span(mac).subspan<2, 4>(), sequence);
    return mac;
  }
  [[nodiscard]] static constexpr FrameTag from_mac(const wire::MacAddress& mac) noexcept {
    return {std::to_integer<std::uint8_t>(mac[1]), wire::load_le<std::uint32_t>(std::span(mac).subspan<2, 4>())};
  }
  /// Of a whole frame, which must be at least as long as an Ethernet header.
  [[nodiscard]] static constexpr FrameTag of(std::span<const std::byte> frame) noexcept {
    return {std::to_integer<std::uint8_t>(frame[7]), wire::load_le<std::uint32_t>(frame.subspan(8, 4))};
  }
  /// True once a slave has processed the frame.
  [[nodiscard]] static constexpr bool processed(const wire::MacAddress& mac) noexcept {
    return (mac[0] & std::byte{0x02}) != std::byte{0};
  }
  constexpr bool operator==(const FrameTag&) const = default;
};

}  // namespace driveline::ecat_master
