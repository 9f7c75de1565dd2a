#include "frame_meter.hpp"

#include "driveline/canopen_wire/frame_bits.hpp"

namespace driveline::canopen {
namespace {

// Bit stuffing (ISO 11898-1, 10.5) as an automaton whose state is the level of the last bit and the number of equal
// bits, 1 to 4: the fifth one is followed by a stuff bit of the other level, which counts as the first one.
constexpr unsigned kLongestRun = 4;
constexpr unsigned kStates = 2 * kLongestRun;

/// What some bits do to a state.
struct Step {
  std::uint8_t next = 0;     ///< state behind them
  std::uint8_t stuffed = 0;  ///< stuff bits among them
};

constexpr unsigned state_of(bool level, unsigned run) noexcept {
  return (level ? kLongestRun : 0U) + run - 1;
}

constexpr Step after(unsigned state, unsigned bits, unsigned count) noexcept {
  bool level = state >= kLongestRun;
  unsigned run = state % kLongestRun + 1;
  Step step;
  for (unsigned i = count; i-- > 0;) {
    const bool bit = (bits >> i & 1U) != 0;
    run = bit == level ? run + 1 : 1;
    level = bit;
    if (run <= kLongestRun) continue;
    ++step.stuffed;
    level = !level;
    run = 1;
  }
  step.next = static_cast<std::uint8_t>(state_of(level, run));
  return step;
}

template <unsigned Count>
constexpr auto stuffing_table() noexcept {
  std::array<std::array<Step, 1U << Count>, kStates> table{};
  for (unsigned state = 0; state < kStates; ++state) {
    for (unsigned bits = 0; bits < 1U << Count; ++bits) table[state][bits] = after(state, bits, Count);
  }
  return table;
}

constexpr unsigned kCrcBits = 15;
constexpr unsigned kCrcMask = 0x7FFF;

constexpr unsigned crc_after(unsigned crc, unsigned bits, unsigned count) noexcept {
  constexpr unsigned kPolynomial = 0x4599;
  for (unsigned i = count; i-- > 0;) {
    const bool next = ((bits >> i ^ crc >> (kCrcBits - 1)) & 1U) != 0;
    crc = (crc << 1 & kCrcMask) ^ (next ? kPolynomial : 0U);
  }
  return crc;
}

constexpr auto crc_table() noexcept {
  std::array<std::uint16_t, 256> table{};
  for (unsigned bits = 0; bits < table.size(); ++bits) table[bits] = static_cast<std::uint16_t>(crc_after(0, bits, 8));
  return table;
}

constexpr auto kBytes = stuffing_table<8>();
constexpr auto kSevenBits = stuffing_table<kCrcBits - 8>();
constexpr auto kCrc = crc_table();

}  // namespace

FrameMeter::FrameMeter(std::uint16_t identifier, std::uint8_t length) noexcept {
  // Behind the start of frame, which is dominant: identifier, RTR, IDE and r0, which are dominant, and the length.
  constexpr unsigned kHeaderBits = 11 + 3 + 4;
  const unsigned header = unsigned{identifier} << 7 | length;
  const auto step = after(state_of(false, 1), header, kHeaderBits);
  run_ = step.next;
  crc_ = static_cast<std::uint16_t>(crc_after(crc_after(0, 0, 1), header, kHeaderBits));
  bits_ = 1 + kHeaderBits + step.stuffed + 8U * length + kCrcBits + kTrailerBits + kInterframeBits;
}

std::uint32_t FrameMeter::bits(std::span<const std::byte> data) const noexcept {
  std::uint32_t total = bits_;
  unsigned crc = crc_;
  unsigned run = run_;
  const auto pass = [&](Step step) noexcept {
    total += step.stuffed;
    run = step.next;
  };
  for (const auto byte : data) {
    const auto bits = std::to_integer<unsigned>(byte);
    pass(kBytes[run][bits]);
    crc = (crc << 8 & kCrcMask) ^ kCrc[(crc >> (kCrcBits - 8) ^ bits) & 0xFF];
  }
  pass(kBytes[run][crc >> (kCrcBits - 8)]);
  pass(kSevenBits[run][crc & ((1U << (kCrcBits - 8)) - 1)]);
  return total;
}

}  // namespace driveline::canopen
