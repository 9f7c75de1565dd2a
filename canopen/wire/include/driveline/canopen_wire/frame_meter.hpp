#pragma once

#include "driveline/canopen_wire/frame.hpp"

namespace driveline::canopen {

/// Bits behind the CRC, which are not stuffed: CRC delimiter, acknowledge slot and delimiter, end of frame.
inline constexpr std::size_t kTrailerBits = 1 + 1 + 1 + 7;
/// Recessive bits between two frames.
inline constexpr std::size_t kInterframeBits = 3;

/// CRC and bit stuffing of a byte at a time, by tables.
namespace frame_table {

inline constexpr unsigned kCrcBits = 15;
inline constexpr unsigned kCrcMask = 0x7FFF;

// Bit stuffing (ISO 11898-1, 10.5) as an automaton whose state is the level of the last bit and the number of equal
// bits, 1 to 4: the fifth one is followed by a stuff bit of the other level, which counts as the first one.
inline constexpr unsigned kLongestRun = 4;
inline constexpr unsigned kStates = 2 * kLongestRun;

// What some bits do to a state, in a byte: the state behind them, as the place of its byte in a row, and the number of
// stuff bits among them.
inline constexpr unsigned kPlaceUnit = 8;
inline constexpr unsigned kPlace = (kStates - 1) * kPlaceUnit;
inline constexpr unsigned kStuffed = kPlaceUnit - 1;

/// What the eight bits of a byte do to a state; the most significant one comes first.
constexpr std::uint64_t after(unsigned state, unsigned bits) noexcept {
  bool level = state >= kLongestRun;
  unsigned run = state % kLongestRun + 1;
  unsigned stuffed = 0;
  for (unsigned i = 8; i-- > 0;) {
    const bool bit = (bits >> i & 1U) != 0;
    run = bit == level ? run + 1 : 1;
    level = bit;
    if (run <= kLongestRun) continue;
    ++stuffed;
    level = !level;
    run = 1;
  }
  return ((level ? kLongestRun : 0U) + run - 1) * kPlaceUnit | stuffed;
}

/// A row for each value of a byte: after() for every state. The rows of all bytes can be loaded at the same time,
/// because only the shift in a row depends on the byte before.
constexpr auto make_stuffing() noexcept {
  std::array<std::uint64_t, 256> rows{};
  for (unsigned bits = 0; bits < rows.size(); ++bits) {
    for (unsigned state = 0; state < kStates; ++state) rows[bits] |= after(state, bits) << kPlaceUnit * state;
  }
  return rows;
}

/// The remainder behind eight more bits that are 0.
constexpr unsigned shifted(unsigned crc) noexcept {
  constexpr unsigned kPolynomial = 0x4599;
  for (int i = 0; i < 8; ++i) crc = (crc << 1 & kCrcMask) ^ ((crc >> (kCrcBits - 1) & 1U) != 0 ? kPolynomial : 0U);
  return crc;
}

/// What a byte adds to the remainder, by the number of bytes that follow it and its value. The CRC is the sum over all
/// bytes, so that none waits for the one before it.
constexpr auto make_crc() noexcept {
  std::array<std::array<std::uint16_t, 256>, Frame::kMaxLength> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte << (kCrcBits - 8);
    for (auto& row : table) {
      crc = shifted(crc);
      row[byte] = static_cast<std::uint16_t>(crc);
    }
  }
  return table;
}

inline constexpr auto kStuffing = make_stuffing();
inline constexpr auto kCrc = make_crc();

/// Stuff bits of a frame. It begins behind a dominant bit.
struct Stuffing {
  std::uint32_t place = 0;  ///< of the byte in each row
  std::uint32_t bits = 0;   ///< stuff bits so far

  /// Adds eight bits.
  constexpr void add(unsigned byte) noexcept {
    const auto step = static_cast<std::uint32_t>(kStuffing[byte] >> place);
    bits += step & kStuffed;
    place = step & kPlace;
  }
};

}  // namespace frame_table

/// Counts the bits on the wire of data or remote frames with the same identifier and length, stuff bits and interframe
/// space included, a byte at a time. What precedes the data is counted once, in the constructor. \rtsafe throughout.
class FrameMeter {
 public:
  FrameMeter() = default;
  /// For frames with identifier, kind and length of this one, which is a data or remote frame.
  explicit constexpr FrameMeter(const Frame& frame) noexcept {
    const bool extended = frame.identifier.extended;
    const unsigned size = extended ? 1 + 11 + 2 + 18 + 3 + 4 : 1 + 11 + 3 + 4;
    const std::uint64_t bits = extended ? extended_header(frame) : base_header(frame);
    // Whole bytes: levels that change in each bit cause no stuff bits, and zeros in front do not change the CRC.
    const std::uint64_t filled = bits | (extended ? 0x1ULL : 0x15ULL) << size;
    for (unsigned i = (size + 7) / 8; i-- > 0;) {
      stuffing_.add(static_cast<unsigned>(filled >> 8 * i) & 0xFFU);
      crc_ = behind_zeros(crc_ ^ (static_cast<unsigned>(bits >> 8 * i) & 0xFFU) << kLowBits);
    }
    for (std::size_t i = 0; i < frame.payload().size(); ++i) crc_ = behind_zeros(crc_);
    bits_ += size + 8 * static_cast<std::uint32_t>(frame.payload().size()) + frame_table::kCrcBits;
    bits_ += static_cast<std::uint32_t>(kTrailerBits + kInterframeBits);
  }

  /// Bits of the frame with this content, as many bytes as in the frame of the constructor. \rtsafe
  [[nodiscard]] constexpr std::uint32_t bits(std::span<const std::byte> data) const noexcept {
    auto stuffing = stuffing_;
    auto crc = crc_;
    const auto add = [&](std::size_t from_end) {
      const auto byte = std::to_integer<unsigned>(data[data.size() - from_end]);
      stuffing.add(byte);
      crc ^= frame_table::kCrc[from_end - 1][byte];
    };
    // Not a loop, whose own instructions would be a third of all.
    switch (data.size()) {
      default:
        add(8);
        [[fallthrough]];
      case 7:
        add(7);
        [[fallthrough]];
      case 6:
        add(6);
        [[fallthrough]];
      case 5:
        add(5);
        [[fallthrough]];
      case 4:
        add(4);
        [[fallthrough]];
      case 3:
        add(3);
        [[fallthrough]];
      case 2:
        add(2);
        [[fallthrough]];
      case 1:
        add(1);
        [[fallthrough]];
      case 0:
        break;
    }
    stuffing.add(crc >> kLowBits);
    // Filled to a byte by the other level of the last bit, which causes no stuff bit.
    stuffing.add((crc << 1 | (~crc & 1U)) & 0xFFU);
    return bits_ + stuffing.bits;
  }

 private:
  /// From the start of frame to the length code.
  [[nodiscard]] static constexpr std::uint64_t base_header(const Frame& frame) noexcept {
    return std::uint64_t{frame.identifier.value} << 7 | end_of_header(frame);
  }
  /// The same, with SRR and IDE between the two parts of the identifier.
  [[nodiscard]] static constexpr std::uint64_t extended_header(const Frame& frame) noexcept {
    const std::uint64_t value = frame.identifier.value;
    return value >> 18 << 27 | std::uint64_t{3} << 25 | (value & 0x3'FFFF) << 7 | end_of_header(frame);
  }
  /// RTR, two dominant bits, and the length code.
  [[nodiscard]] static constexpr std::uint64_t end_of_header(const Frame& frame) noexcept {
    return (frame.kind == FrameKind::kRemote ? 1ULL << 6 : 0ULL) | frame.length;
  }

  /// frame_table::shifted() by its table.
  [[nodiscard]] static constexpr std::uint32_t behind_zeros(std::uint32_t crc) noexcept {
    return (crc << 8 & frame_table::kCrcMask) ^ frame_table::kCrc[0][crc >> kLowBits];
  }

  static constexpr unsigned kLowBits = frame_table::kCrcBits - 8;  ///< bits of the CRC behind its first eight

  std::uint32_t bits_ = 0;          ///< bits of the frame without stuff bits
  std::uint32_t crc_ = 0;           ///< CRC of the frame if its data were 0
  frame_table::Stuffing stuffing_;  ///< before the data
};

/// Bits of a data or remote frame on the wire, with its real stuff bits and the interframe space: of a base frame with
/// n bytes 47 + 8n and the stuff bits, at most (33 + 8n) / 4 of them. \rtsafe
[[nodiscard]] constexpr std::size_t bit_count(const Frame& frame) noexcept {
  return FrameMeter(frame).bits(frame.payload());
}

}  // namespace driveline::canopen
