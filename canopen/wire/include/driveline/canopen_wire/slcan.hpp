#pragma once

#include "driveline/canopen_wire/frame_text.hpp"

namespace driveline::canopen {

/// Frames as lines of text, as serial CAN adapters exchange them with a computer (LAWICEL AB, CAN232 and CANUSB
/// manuals; known as slcan): "t1232AABB" is a data frame 123h with two bytes, T has an extended identifier, r and R are
/// remote frames.
namespace slcan {

inline constexpr char kOk = '\r';                             ///< end of a line, and the positive answer
inline constexpr char kError = '\a';                          ///< the negative answer
inline constexpr std::uint16_t kTimeStampsPerRound = 60'000;  ///< time stamps count milliseconds from 0 to EA5Fh
/// Bit rates of the commands S0 to S8 in bit/s.
inline constexpr std::array<std::uint32_t, 9> kBitRates{10'000,  20'000,  50'000,  100'000,  125'000,
                                                        250'000, 500'000, 800'000, 1'000'000};

/// A line with a frame: at most 'T', 8 digits, the length, 16 digits, a time stamp and the end of the line.
using Line = Text<31>;

/// A frame with the time stamp of its line.
struct StampedFrame {
  Frame frame;                                ///< data or remote frame
  std::optional<std::uint16_t> milliseconds;  ///< less than kTimeStampsPerRound
  constexpr bool operator==(const StampedFrame&) const = default;
};

/// The line of a data or remote frame, with kOk at its end; `milliseconds`: time stamp. Empty for an error frame, which
/// the protocol does not have. \rtsafe
[[nodiscard]] constexpr Line line_of(const Frame& frame, std::optional<std::uint16_t> milliseconds = {}) noexcept {
  Line line;
  if (!frame.valid()) return line;
  const bool remote = frame.kind == FrameKind::kRemote;
  line.add(frame.identifier.extended ? (remote ? 'R' : 'T') : (remote ? 'r' : 't'));
  add_identifier(line, frame.identifier);
  line.add_hex(frame.length, 1);
  add_bytes(line, frame.payload());
  if (milliseconds) line.add_hex(*milliseconds, 4);
  return line.add(kOk);
}

/// Reads a line without its end. Empty: not exactly one frame, with or without a time stamp. \rtsafe
[[nodiscard]] constexpr std::optional<StampedFrame> parse_line(std::string_view line) noexcept {
  if (line.empty()) return std::nullopt;
  const char letter = line.front();
  const bool extended = letter == 'T' || letter == 'R';
  const bool remote = letter == 'r' || letter == 'R';
  if (!extended && !remote && letter != 't') return std::nullopt;
  line.remove_prefix(1);
  const std::size_t digits = extended ? 8 : 3;
  if (line.size() <= digits) return std::nullopt;
  const auto value = hex_number(line.substr(0, digits));
  const auto length = hex_number(line.substr(digits, 1));
  line.remove_prefix(digits + 1);
  if (!value || !length || *length > Frame::kMaxLength) return std::nullopt;
  const Identifier identifier{*value, extended};
  const std::size_t data = remote ? 0 : 2 * *length;
  if (!identifier.valid() || (line.size() != data && line.size() != data + 4)) return std::nullopt;
  const auto frame = remote ? Frame::remote(identifier, static_cast<std::uint8_t>(*length))
                            : parse_data(identifier, line.substr(0, data));
  if (!frame) return std::nullopt;
  StampedFrame stamped{*frame, std::nullopt};
  if (line.size() == data) return stamped;
  const auto stamp = hex_number(line.substr(data));
  if (!stamp || *stamp >= kTimeStampsPerRound) return std::nullopt;
  stamped.milliseconds = static_cast<std::uint16_t>(*stamp);
  return stamped;
}

/// Bit rate in bit/s of the command `s` with bus timing registers 0 and 1 of an SJA1000 with 16 MHz; 0: the registers
/// make no bit (SJA1000 data sheet 6.5). \rtsafe
[[nodiscard]] constexpr std::uint32_t bit_rate_of(std::uint16_t bus_timing) noexcept {
  const std::uint32_t prescaler = (bus_timing >> 8U & 0x3FU) + 1;
  const std::uint32_t segment1 = (bus_timing & 0xFU) + 1;
  const std::uint32_t segment2 = (bus_timing >> 4U & 0x7U) + 1;
  return 8'000'000 / (prescaler * (1 + segment1 + segment2));
}

/// The command that sets a bit rate: "S6" where there is one of kBitRates, otherwise "s" with bus timing registers that
/// make it exactly, of 8 to 25 time quanta with the sample point next to 87.5 %, where CiA 301 wants it. Empty: no
/// registers do.
[[nodiscard]] constexpr Text<8> bit_rate_command(std::uint32_t bit_rate) noexcept {
  Text<8> command;
  for (std::size_t i = 0; i < kBitRates.size(); ++i) {
    if (kBitRates[i] == bit_rate) return command.add('S').add_decimal(i);
  }
  std::uint32_t best = ~0U;  // distance from the sample point, in thousandths of a bit
  std::uint16_t registers = 0;
  for (std::uint32_t timing = 0; timing < 0x2000; ++timing) {
    const auto candidate = static_cast<std::uint16_t>((timing >> 7U) << 8U | (timing & 0x7FU));
    const std::uint32_t before = 2 + (candidate & 0xFU);  // quanta before the sample point
    const std::uint32_t quanta = before + 1 + (candidate >> 4U & 0x7U);
    const std::uint32_t prescaler = (candidate >> 8U & 0x3FU) + 1;
    if (quanta < 8 || bit_rate_of(candidate) != bit_rate || bit_rate * prescaler * quanta != 8'000'000) continue;
    const std::uint32_t sample_point = 1000 * before / quanta;
    const std::uint32_t distance = sample_point > 875 ? sample_point - 875 : 875 - sample_point;
    if (distance >= best) continue;
    best = distance;
    registers = candidate;
  }
  return best == ~0U ? command : command.add('s').add_hex(registers, 4);
}

/// Bits of the answer to the command F (LAWICEL AB, CANUSB manual).
namespace status_flag {
inline constexpr std::uint8_t kErrorWarning = 0x04;  ///< an error counter has reached 96
inline constexpr std::uint8_t kDataOverrun = 0x08;   ///< frames were lost since the last answer
inline constexpr std::uint8_t kErrorPassive = 0x20;  ///< an error counter has reached 128
}  // namespace status_flag

}  // namespace slcan

}  // namespace driveline::canopen
