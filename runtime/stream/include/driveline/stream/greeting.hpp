#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

#include "driveline/stream/records.hpp"

/// The two messages over the Unix socket (SOCK_SEQPACKET) of a running line, before the records.
namespace driveline::stream {

/// Text of fixed size, ended by a zero.
template <std::size_t kBytes>
struct FixedText {
  std::array<char, kBytes> bytes{};  ///< the text, and zeros

  /// Takes over what fits.
  constexpr void set(std::string_view text) noexcept {
    bytes = {};
    std::copy_n(text.begin(), std::min(text.size(), kBytes - 1), bytes.begin());
  }
  /// Up to the zero; without one, all of it.
  [[nodiscard]] constexpr std::string_view text() const noexcept {
    const auto end = std::find(bytes.begin(), bytes.end(), '\0');
    return {bytes.data(), static_cast<std::size_t>(end - bytes.begin())};
  }
};

/// Both messages begin so ("drvlnstr" in memory).
inline constexpr std::uint64_t kGreetingMagic = 0x7274'736E'6C76'7264;
/// Longest name of an axis or a client, with the zero.
inline constexpr std::size_t kNameBytes = 64;

/// From the client, once.
struct Hello {
  std::uint64_t magic = kGreetingMagic;                ///< kGreetingMagic
  std::uint32_t version = kVersion;                    ///< of the sender
  std::uint32_t axis_count = 0;                        ///< of `axes`, at least 1
  std::uint32_t power = 0;                             ///< 1: the axes are to be switched on
  std::uint32_t take_over = 0;                         ///< 1: also axes that others command, who lose them
  FixedText<kNameBytes> name{};                        ///< of the client, for people
  std::array<FixedText<kNameBytes>, kMaxAxes> axes{};  ///< as in the line description
};

/// What an axis allows.
struct AxisBounds {
  double lowest = 0.0;            ///< position as the drive counts, rad or m
  double highest = 0.0;           ///< position
  double max_velocity = 0.0;      ///< rad/s or m/s
  double max_acceleration = 0.0;  ///< rad/s^2 or m/s^2; setpoints beyond it are followed as fast as it allows
};

/// From the line. When it accepts, it comes with two descriptors (SCM_RIGHTS): ring, then broadcast.
struct Answer {
  std::uint64_t magic = kGreetingMagic;       ///< kGreetingMagic
  std::uint32_t version = kVersion;           ///< of the sender
  std::uint32_t accepted = 0;                 ///< 1
  std::int64_t period_ns = 0;                 ///< of the cycle
  std::int64_t keep_alive_ns = 0;             ///< longest time between two records
  std::int64_t longest_ahead_ns = 0;          ///< setpoints of later times are refused
  std::uint32_t records_per_cycle = 0;        ///< that the line takes
  std::uint32_t reserved = 0;                 ///< 0
  FixedText<256> refusal{};                   ///< a sentence when it does not accept
  std::array<AxisBounds, kMaxAxes> bounds{};  ///< of the axes, in the order of the Hello
};

/// A message as bytes: both ends are on one machine.
template <typename Message>
[[nodiscard]] std::array<std::byte, sizeof(Message)> to_bytes(const Message& message) noexcept {
  std::array<std::byte, sizeof(Message)> bytes{};
  std::memcpy(bytes.data(), &message, sizeof(Message));
  return bytes;
}
/// None: it is not of this size, or does not begin with the magic. Its version may be any.
template <typename Message>
[[nodiscard]] std::optional<Message> from_bytes(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != sizeof(Message)) return std::nullopt;
  Message message;
  std::memcpy(&message, bytes.data(), sizeof(Message));
  if (message.magic != kGreetingMagic) return std::nullopt;
  return message;
}

}  // namespace driveline::stream
