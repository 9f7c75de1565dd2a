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

/// The messages over the Unix socket (SOCK_SEQPACKET) of a running line that precede the records: Hello, Answer,
/// Mapped, and a second Answer.
namespace driveline::stream {

/// Text of fixed size, terminated by a zero.
template <std::size_t kBytes>
struct FixedText {
  std::array<char, kBytes> bytes{};  ///< the text, padded with zeros

  /// Sets the text, truncated to the size.
  constexpr void set(std::string_view text) noexcept {
    bytes = {};
    std::copy_n(text.begin(), std::min(text.size(), kBytes - 1), bytes.begin());
  }
  /// Returns the text up to the zero, or all bytes if there is none.
  [[nodiscard]] constexpr std::string_view text() const noexcept {
    const auto end = std::find(bytes.begin(), bytes.end(), '\0');
    return {bytes.data(), static_cast<std::size_t>(end - bytes.begin())};
  }
};

/// First bytes of all messages ("drvlnstr" in memory).
inline constexpr std::uint64_t kGreetingMagic = 0x7274'736E'6C76'7264;
/// Longest name of an axis or a client, including the zero.
inline constexpr std::size_t kNameBytes = 64;

/// First message from the client.
struct Hello {
  std::uint64_t magic = kGreetingMagic;                ///< kGreetingMagic
  std::uint32_t version = kVersion;                    ///< version of the sender
  std::uint32_t axis_count = 0;                        ///< number of valid `axes`, at least 1
  std::uint32_t power = 0;                             ///< 1: switch the axes on
  std::uint32_t take_over = 0;                         ///< 1: take over axes of other clients, too, which lose them
  FixedText<kNameBytes> name{};                        ///< name of the client, for messages
  std::array<FixedText<kNameBytes>, kMaxAxes> axes{};  ///< names in the line description
};

/// Second message from the client: it has mapped the memory. Only then can the line seal the memory against its return
/// to the system, by which the client would delay the cycle.
struct Mapped {
  std::uint64_t magic = kGreetingMagic;  ///< kGreetingMagic
  std::uint32_t version = kVersion;      ///< version of the sender
  std::uint32_t reserved = 0;            ///< 0
};

/// Limits of an axis.
struct AxisBounds {
  double lowest = 0.0;            ///< lowest position as the drive counts, rad or m
  double highest = 0.0;           ///< highest position, rad or m
  double max_velocity = 0.0;      ///< rad/s or m/s
  double max_acceleration = 0.0;  ///< rad/s^2 or m/s^2; setpoints beyond it are followed as fast as it permits
};

/// Message from the line, after the Hello and again after Mapped. If the first one accepts, two descriptors are
/// attached (SCM_RIGHTS): ring, then broadcast. The second one begins the session.
struct Answer {
  std::uint64_t magic = kGreetingMagic;       ///< kGreetingMagic
  std::uint32_t version = kVersion;           ///< version of the sender
  std::uint32_t accepted = 0;                 ///< 1: accepted
  std::int64_t period_ns = 0;                 ///< cycle time
  std::int64_t keep_alive_ns = 0;             ///< longest time between two records
  std::int64_t longest_ahead_ns = 0;          ///< setpoints for later times are refused
  std::uint32_t records_per_cycle = 0;        ///< most records that the line processes per cycle
  std::uint32_t reserved = 0;                 ///< 0
  FixedText<256> refusal{};                   ///< reason, as a sentence, if it does not accept
  std::array<AxisBounds, kMaxAxes> bounds{};  ///< bounds of the axes, in the order of the Hello
};

/// Returns the bytes of a message; both ends are on one machine.
template <typename Message>
[[nodiscard]] std::array<std::byte, sizeof(Message)> to_bytes(const Message& message) noexcept {
  std::array<std::byte, sizeof(Message)> bytes{};
  std::memcpy(bytes.data(), &message, sizeof(Message));
  return bytes;
}
/// Returns the message; none: the size differs, or it does not start with the magic. Any version is accepted.
template <typename Message>
[[nodiscard]] std::optional<Message> from_bytes(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != sizeof(Message)) return std::nullopt;
  Message message;
  std::memcpy(&message, bytes.data(), sizeof(Message));
  if (message.magic != kGreetingMagic) return std::nullopt;
  return message;
}

}  // namespace driveline::stream
