#pragma once

#include "driveline/canopen_wire/frame_meter.hpp"

namespace driveline::canopen {

/// The bits of a frame that bit stuffing concerns, from the start of frame to the CRC, without stuff bits. \rtsafe
/// throughout.
class FrameBits {
 public:
  /// Start of frame, arbitration, control, eight data bytes and CRC of an extended frame.
  static constexpr std::size_t kMost = 1 + 32 + 6 + 64 + 15;

  /// Precondition: `frame` is a data or remote frame.
  explicit constexpr FrameBits(const Frame& frame) noexcept {
    append(0, 1);  // start of frame
    const std::uint32_t remote = frame.kind == FrameKind::kRemote ? 1 : 0;
    if (frame.identifier.extended) {
      append(frame.identifier.value >> 18, 11);
      append(3, 2);  // SRR, IDE
      append(frame.identifier.value & 0x3'FFFF, 18);
      append(remote << 2, 3);  // RTR, r1, r0
    } else {
      append(frame.identifier.value, 11);
      append(remote << 2, 3);  // RTR, IDE, r0
    }
    append(frame.length, 4);
    for (const std::byte byte : frame.payload()) append(std::to_integer<std::uint32_t>(byte), 8);
    crc_ = remainder_;
    append(crc_, 15);
  }

  /// Number of bits. \rtsafe
  [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
  /// The bit at `place`, true: recessive. Precondition: below size(). \rtsafe
  [[nodiscard]] constexpr bool operator[](std::size_t place) const noexcept {
    return (words_[place / 64] >> (place % 64) & 1U) != 0;
  }
  /// The CRC-15 of the frame (polynomial 4599h, initial value 0). \rtsafe
  [[nodiscard]] constexpr std::uint16_t crc() const noexcept { return crc_; }
  /// Stuff bits that the sender inserts: one of the opposite level after five equal bits, which counts as the first bit
  /// of what follows (ISO 11898-1, 10.5). \rtsafe
  [[nodiscard]] constexpr std::size_t stuff_bits() const noexcept { return stuff_bits_before(size_); }
  /// Stuff bits among the bits up to and including the one before `place`. \rtsafe
  [[nodiscard]] constexpr std::size_t stuff_bits_before(std::size_t place) const noexcept {
    std::size_t stuffed = 0;
    unsigned run = 0;
    bool level = true;
    for (std::size_t i = 0; i < place; ++i) {
      const bool bit = (*this)[i];
      run = bit == level ? run + 1 : 1;
      level = bit;
      if (run < 5) continue;
      ++stuffed;
      level = !level;
      run = 1;
    }
    return stuffed;
  }

 private:
  constexpr void append(std::uint32_t value, unsigned count) noexcept {
    for (unsigned i = count; i-- > 0;) {
      const bool bit = (value >> i & 1U) != 0;
      if (bit) words_[size_ / 64] |= std::uint64_t{1} << (size_ % 64);
      ++size_;
      const bool next = bit != ((remainder_ >> 14 & 1U) != 0);
      remainder_ = static_cast<std::uint16_t>((2U * remainder_ & 0x7FFFU) ^ (next ? 0x4599U : 0U));
    }
  }

  std::array<std::uint64_t, 2> words_{};
  std::size_t size_ = 0;
  std::uint16_t remainder_ = 0;  ///< of the division of all bits so far
  std::uint16_t crc_ = 0;
};

}  // namespace driveline::canopen
