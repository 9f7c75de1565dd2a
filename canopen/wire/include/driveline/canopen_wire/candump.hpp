#pragma once

#include "driveline/canopen_wire/frame_text.hpp"

namespace driveline::canopen {

/// Lines of the log file of candump, which the tools of can-utils and python-can read: "(1436509052.249713) can0
/// 044#2A366C2BBA".
namespace candump {

/// A line without its end; names of interfaces have up to 15 characters.
using Line = Text<72>;

/// The line of a frame that was on `interface` `microseconds` after 1970. Error frames are those of linux/can/error.h
/// with CAN_ERR_BUSERROR. \rtsafe
[[nodiscard]] constexpr Line line_of(const Frame& frame, std::string_view interface,
                                     std::uint64_t microseconds) noexcept {
  constexpr std::uint64_t kMicrosecondsPerSecond = 1'000'000;
  Line line;
  line.add('(')
      .add_decimal(microseconds / kMicrosecondsPerSecond, 10)
      .add('.')
      .add_decimal(microseconds % kMicrosecondsPerSecond, 6);
  line.add(") ").add(interface.substr(0, 15)).add(' ');
  if (frame.kind == FrameKind::kError) return line.add("20000080#0000000000000000");
  add_identifier(line, frame.identifier);
  line.add('#');
  if (frame.kind == FrameKind::kRemote) {
    line.add('R');
    if (frame.length > 0) line.add_hex(frame.length, 1);
  }
  add_bytes(line, frame.payload());
  return line;
}

/// Reads a frame as it is written behind the name of the interface: "044#2A366C2BBA", "123#R4". Empty: anything else,
/// also frames of CAN FD. \rtsafe
[[nodiscard]] constexpr std::optional<Frame> parse_frame(std::string_view text) noexcept {
  const auto separator = text.find('#');
  if (separator == std::string_view::npos) return std::nullopt;
  const auto digits = text.substr(0, separator);
  const auto identifier = parse_identifier(digits);
  if (!identifier || (digits.size() != 3 && digits.size() != 8)) return std::nullopt;
  const auto content = text.substr(separator + 1);
  if (content.empty() || (content.front() | 0x20) != 'r') return parse_data(*identifier, content);
  if (content.size() == 1) return Frame::remote(*identifier, 0);
  const auto length = hex_number(content.substr(1));
  if (!length || content.size() > 2 || *length > Frame::kMaxLength) return std::nullopt;
  return Frame::remote(*identifier, static_cast<std::uint8_t>(*length));
}

}  // namespace candump

}  // namespace driveline::canopen
