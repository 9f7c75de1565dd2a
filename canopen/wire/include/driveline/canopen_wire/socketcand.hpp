#pragma once

#include "driveline/canopen_wire/frame_text.hpp"

namespace driveline::canopen {

/// Frames as elements "< ... >" of the protocol of socketcand, the daemon that serves CAN interfaces over TCP
/// (socketcand, doc/protocol.md).
namespace socketcand {

/// An element; the longest one is a frame with an extended identifier, eight bytes and a time stamp.
using Element = Text<72>;

/// What a server tells of a frame, `microseconds` after its epoch: "< frame 123 23.424242 11223344 >", "< rtr 123
/// 23.424242 4 >" for a remote frame, "< error ... >" for an error frame. Data are without blanks, as the daemon writes
/// them. \rtsafe
[[nodiscard]] constexpr Element element_of(const Frame& frame, std::uint64_t microseconds) noexcept {
  constexpr std::uint64_t kMicrosecondsPerSecond = 1'000'000;
  Element element;
  if (frame.kind == FrameKind::kError)
    return element.add("< error 00000080 >");  // CAN_ERR_BUSERROR of linux/can/error.h
  if (!frame.valid()) return element;
  const bool remote = frame.kind == FrameKind::kRemote;
  element.add(remote ? "< rtr " : "< frame ");
  add_identifier(element, frame.identifier);
  element.add(' ').add_decimal(microseconds / kMicrosecondsPerSecond).add('.');
  element.add_decimal(microseconds % kMicrosecondsPerSecond, 6).add(' ');
  if (remote) element.add_hex(frame.length, 1);
  add_bytes(element, frame.payload());
  return element.add(" >");
}

/// The command with which a client sends a frame: "< send 123 2 11 F1 >" or "< sendrtr 123 2 >". Empty for a frame that
/// is not valid. \rtsafe
[[nodiscard]] constexpr Element command_of(const Frame& frame) noexcept {
  Element element;
  if (!frame.valid()) return element;
  element.add(frame.kind == FrameKind::kRemote ? "< sendrtr " : "< send ");
  add_identifier(element, frame.identifier);
  element.add(' ').add_hex(frame.length, 1);
  for (const std::byte byte : frame.payload()) element.add(' ').add_hex(std::to_integer<std::uint32_t>(byte), 2);
  return element.add(" >");
}

/// Reads the words behind `send` or `sendrtr`: identifier, length, and as many bytes of one or two digits. Empty:
/// anything else. \rtsafe
[[nodiscard]] constexpr std::optional<Frame> parse_command(FrameKind kind, std::string_view words) noexcept {
  const auto identifier = parse_identifier(next_word(words));
  const auto length = hex_number(next_word(words));
  if (!identifier || !length || *length > Frame::kMaxLength) return std::nullopt;
  Frame frame{*identifier, kind, static_cast<std::uint8_t>(*length), {}};
  const std::size_t bytes = kind == FrameKind::kData ? *length : 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    const auto byte = hex_number(next_word(words));
    if (!byte || *byte > 0xFF) return std::nullopt;
    frame.data[i] = static_cast<std::byte>(*byte);
  }
  return next_word(words).empty() ? std::optional(frame) : std::nullopt;
}

/// Reads what a server tells of a frame, the text between "<" and ">"; data with or without blanks. Empty: anything
/// else. \rtsafe
[[nodiscard]] constexpr std::optional<Frame> parse_element(std::string_view words) noexcept {
  const auto kind = next_word(words);
  if (kind != "frame" && kind != "rtr") return std::nullopt;
  const auto identifier = parse_identifier(next_word(words));
  if (!identifier || next_word(words).empty()) return std::nullopt;  // the time is not used
  if (kind == "rtr") {
    const auto length = hex_number(next_word(words));
    if (!length || *length > Frame::kMaxLength || !next_word(words).empty()) return std::nullopt;
    return Frame::remote(*identifier, static_cast<std::uint8_t>(*length));
  }
  Text<2 * Frame::kMaxLength + 2> digits;  // longer than any frame, so that more bytes are noticed
  for (auto word = next_word(words); !word.empty(); word = next_word(words)) digits.add(word);
  return parse_data(*identifier, digits.view());
}

}  // namespace socketcand

}  // namespace driveline::canopen
