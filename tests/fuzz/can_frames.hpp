#pragma once

#include <algorithm>
#include <chrono>
#include <string_view>

#include "driveline/bytes/endian.hpp"
#include "driveline/canopen_wire/frame.hpp"
#include "fuzz_target.hpp"
#include "support/bytes.hpp"

/// Frames of a CAN bus as the input of a fuzz target: two bytes of identifier, with bit 15 for a remote frame and bit
/// 14 for an extended one, a byte of length, the data, and a byte of time in 100 us.
namespace driveline::fuzz {

/// The frame at the start of the input, which is shortened by it.
inline canopen::Frame take_frame(std::span<const std::byte>& input) {
  const auto word = bytes::load_le<std::uint16_t>(input);
  const bool extended = (word & 0x4000U) != 0;
  const auto length = static_cast<std::uint8_t>(std::to_integer<unsigned>(input[2]) % 9);
  const canopen::Identifier identifier{word & 0x7FFU, extended};
  input = input.subspan(3);
  if ((word & 0x8000U) != 0) return canopen::Frame::remote(identifier, length);
  const auto payload = input.first(std::min<std::size_t>(length, input.size()));
  input = input.subspan(payload.size());
  return canopen::Frame::of(identifier, payload);
}

/// The time behind a frame, by which the input is shortened.
inline std::chrono::microseconds take_time(std::span<const std::byte>& input) {
  const auto time = input.empty() ? 1 : std::to_integer<int>(input[0]);
  if (!input.empty()) input = input.subspan(1);
  return time * std::chrono::microseconds{100};
}

/// Adds a frame to an input.
inline void append(Bytes& input, std::uint16_t word, std::string_view payload, unsigned time = 5) {
  const auto data = bytes_test::hex(payload);
  input.push_back(static_cast<std::byte>(word & 0xFFU));
  input.push_back(static_cast<std::byte>(word >> 8));
  input.push_back(static_cast<std::byte>(data.size()));
  input.insert(input.end(), data.begin(), data.end());
  input.push_back(static_cast<std::byte>(time));
}

}  // namespace driveline::fuzz
