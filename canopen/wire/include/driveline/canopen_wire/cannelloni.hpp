#pragma once

#include "driveline/bytes/endian.hpp"
#include "driveline/canopen_wire/frame.hpp"

namespace driveline::canopen {

/// Packets of cannelloni, a tunnel for CAN frames in UDP (cannelloni, doc/udp_format.md, version 2): a header and
/// frames, all numbers big endian.
namespace cannelloni {

inline constexpr std::size_t kHeaderBytes = 5;     ///< version, operation, sequence number, count of frames
inline constexpr std::byte kVersion{2};            ///< version of the format
inline constexpr std::byte kData{0};               ///< operation: the packet has frames
inline constexpr std::size_t kMaxFrameBytes = 13;  ///< identifier, length, eight bytes

/// Flags in the identifier of linux/can.h.
namespace flag {
inline constexpr std::uint32_t kExtended = 0x8000'0000;  ///< CAN_EFF_FLAG
inline constexpr std::uint32_t kRemote = 0x4000'0000;    ///< CAN_RTR_FLAG
inline constexpr std::uint32_t kError = 0x2000'0000;     ///< CAN_ERR_FLAG
inline constexpr std::uint8_t kFd = 0x80;                ///< in the length: a frame of CAN FD
}  // namespace flag

/// Writes packets into a buffer.
class Writer {
 public:
  /// Starts a packet in `buffer`, which has at least kHeaderBytes. \rtsafe
  constexpr Writer(std::span<std::byte> buffer, std::uint8_t sequence) noexcept : buffer_(buffer) {
    buffer_[0] = kVersion;
    buffer_[1] = kData;
    buffer_[2] = static_cast<std::byte>(sequence);
    store_count();
  }
  /// Appends a data or remote frame; false: it does not fit, or is neither. \rtsafe
  constexpr bool add(const Frame& frame) noexcept {
    const auto payload = frame.payload();
    if (!frame.valid() || buffer_.size() - size_ < 5 + payload.size()) return false;
    const std::uint32_t flags =
        (frame.identifier.extended ? flag::kExtended : 0U) | (frame.kind == FrameKind::kRemote ? flag::kRemote : 0U);
    const std::uint32_t identifier = frame.identifier.value | flags;
    bytes::store_be16(buffer_.subspan(size_), static_cast<std::uint16_t>(identifier >> 16U));
    bytes::store_be16(buffer_.subspan(size_ + 2), static_cast<std::uint16_t>(identifier));
    buffer_[size_ + 4] = static_cast<std::byte>(frame.length);
    std::copy(payload.begin(), payload.end(), buffer_.begin() + static_cast<std::ptrdiff_t>(size_ + 5));
    size_ += 5 + payload.size();
    ++count_;
    store_count();
    return true;
  }
  /// The packet so far. \rtsafe
  [[nodiscard]] constexpr std::span<const std::byte> packet() const noexcept { return buffer_.first(size_); }
  /// Number of frames in it. \rtsafe
  [[nodiscard]] constexpr std::uint16_t count() const noexcept { return count_; }

 private:
  constexpr void store_count() noexcept { bytes::store_be16(buffer_.subspan(3), count_); }

  std::span<std::byte> buffer_;
  std::size_t size_ = kHeaderBytes;
  std::uint16_t count_ = 0;
};

/// Reads the frames of a packet.
class Reader {
 public:
  /// \rtsafe
  explicit constexpr Reader(std::span<const std::byte> packet) noexcept {
    if (packet.size() < kHeaderBytes || packet[0] != kVersion || packet[1] != kData) return;
    sequence_ = std::to_integer<std::uint8_t>(packet[2]);
    left_ = bytes::load_be16(packet.subspan(3));
    rest_ = packet.subspan(kHeaderBytes);
    good_ = true;
  }
  /// Whether all read so far is a packet of this format. \rtsafe
  [[nodiscard]] constexpr bool good() const noexcept { return good_; }
  /// Sequence number of the packet. \rtsafe
  [[nodiscard]] constexpr std::uint8_t sequence() const noexcept { return sequence_; }
  /// The next classic frame; empty at the end of the packet, or of what is good of it. Frames of CAN FD and error
  /// frames are passed over. \rtsafe
  constexpr std::optional<Frame> next() noexcept {
    while (good_ && left_ > 0) {
      --left_;
      if (const auto frame = take()) return frame;
    }
    return std::nullopt;
  }

 private:
  constexpr std::optional<Frame> take() noexcept {
    if (rest_.size() < 5) return fail();
    const std::uint32_t raw =
        static_cast<std::uint32_t>(bytes::load_be16(rest_)) << 16U | bytes::load_be16(rest_.subspan(2));
    const auto length = std::to_integer<std::uint8_t>(rest_[4]);
    const bool remote = (raw & flag::kRemote) != 0;
    const bool fd = (length & flag::kFd) != 0;
    const std::size_t head = fd ? 6 : 5;
    const std::size_t data = remote ? 0 : length & 0x7FU;
    if (rest_.size() < head + data || (!fd && length > Frame::kMaxLength)) return fail();
    const auto payload = rest_.subspan(head, data);
    rest_ = rest_.subspan(head + data);
    if (fd || (raw & flag::kError) != 0) return std::nullopt;
    const Identifier identifier{raw & Identifier::kExtendedMask, (raw & flag::kExtended) != 0};
    if (!identifier.valid()) return std::nullopt;
    return remote ? Frame::remote(identifier, length) : Frame::of(identifier, payload);
  }
  constexpr std::optional<Frame> fail() noexcept {
    good_ = false;
    return std::nullopt;
  }

  std::span<const std::byte> rest_;
  std::uint16_t left_ = 0;
  std::uint8_t sequence_ = 0;
  bool good_ = false;
};

}  // namespace cannelloni

}  // namespace driveline::canopen
