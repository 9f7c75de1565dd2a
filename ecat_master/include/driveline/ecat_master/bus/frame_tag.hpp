#pragma once

#include <cstdint>

#include "driveline/wire/ethernet.hpp"

namespace driveline::ecat_master {

/// The identity of a frame, carried in its Ethernet source address.
///
/// The 8-bit datagram index repeats after 256 frames, 32 ms at 8 kHz, so a late frame could be mistaken for a new one.
/// Slave controllers ignore the source address; the first slave only sets the "locally administered" bit in its first
/// byte (ESC data sheet I, "Ethernet frame processing"). The master therefore numbers its frames there: the upper five
/// bits of byte 0 and byte 1 distinguish the masters on a wire, bytes 2-5 are a sequence number that lasts for days.
/// The multicast bit of byte 0 stays clear, and so does bit 2, with which a ring marks its second copy
/// (port::RedundantPort).
///
/// A guest is a tool on a line that may already have a master. It counts only in the lower half of the sequence number;
/// the upper half marks it, so that the master recognises its frames.
struct FrameTag {
  /// Number of values of `instance`: 13 bits.
  static constexpr std::uint16_t kInstances = 0x2000;
  /// Upper half of `sequence` in the frames of a guest; a master reaches this value after days at 8 kHz.
  static constexpr std::uint32_t kGuest = 0xFFFF'0000;

  std::uint16_t instance = 0;  ///< instance of the master, below kInstances
  std::uint32_t sequence = 0;  ///< number of the frame

  /// The tag as a source address. \rtsafe
  [[nodiscard]] constexpr wire::MacAddress to_mac() const noexcept {
    wire::MacAddress mac{};
    mac[0] = static_cast<std::byte>((std::uint32_t{instance} >> 8U << 3U) & 0xF8U);
    mac[1] = static_cast<std::byte>(instance & 0xFFU);
    bytes::store_le(std::span(mac).subspan<2, 4>(), sequence);
    return mac;
  }
  /// The tag in a received source address, with or without the bit that slaves set. \rtsafe
  [[nodiscard]] static constexpr FrameTag from_mac(const wire::MacAddress& mac) noexcept { return from_source(mac); }
  /// The tag of a whole frame, which must be at least as long as an Ethernet header. \rtsafe
  [[nodiscard]] static constexpr FrameTag of(std::span<const std::byte> frame) noexcept {
    return from_source(frame.subspan(6, 6));
  }
  /// The tag of a guest's frame, number `count` modulo 2^16. \rtsafe
  [[nodiscard]] static constexpr FrameTag of_guest(std::uint16_t instance, std::uint32_t count) noexcept {
    return {instance, kGuest | (count & ~kGuest)};
  }
  /// Whether a guest sent the frame. \rtsafe
  [[nodiscard]] constexpr bool guest() const noexcept { return (sequence & kGuest) == kGuest; }
  /// Whether a slave has processed the frame.
  [[nodiscard]] static constexpr bool processed(const wire::MacAddress& mac) noexcept {
    return (mac[0] & std::byte{0x02}) != std::byte{0};
  }
  constexpr bool operator==(const FrameTag&) const = default;

 private:
  static constexpr FrameTag from_source(std::span<const std::byte> source) noexcept {
    const unsigned high = std::to_integer<unsigned>(source[0]) >> 3U;
    return {static_cast<std::uint16_t>(high << 8U | std::to_integer<unsigned>(source[1])),
            bytes::load_le<std::uint32_t>(source.subspan(2, 4))};
  }
};

/// An instance for another master: masters of this process get different instances until all are used. Other processes
/// and machines start from a random number, so two of them collide once in 8192 times. Any thread, not real-time safe.
[[nodiscard]] std::uint16_t next_frame_instance();

}  // namespace driveline::ecat_master
