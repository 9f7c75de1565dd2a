#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Time-outs of a slave's mailboxes; empty: the default (MailboxChannel::Settings).
struct MailboxTimeouts {
  std::optional<std::chrono::nanoseconds> request;   ///< until the slave takes a message
  std::optional<std::chrono::nanoseconds> response;  ///< until the slave answers
  /// Interval at which a request without an answer is sent again; 0: never; empty: a quarter of the time-out of the
  /// answer.
  std::optional<std::chrono::nanoseconds> repeat{};
  constexpr bool operator==(const MailboxTimeouts&) const = default;
};

/// Position of a slave's mailboxes: sync manager 0 (to the slave) and 1 (from the slave).
struct MailboxWindow {
  std::uint16_t out_address = 0;  ///< address of the mailbox to the slave, in the slave's memory
  std::uint16_t out_length = 0;   ///< its length in bytes
  std::uint16_t in_address = 0;   ///< address of the mailbox from the slave, in the slave's memory
  std::uint16_t in_length = 0;    ///< its length in bytes
  MailboxTimeouts timeouts{};     ///< time-outs of this slave
  std::uint8_t last_counter = 0;  ///< counter of the last message to the slave, 1 to 7; 0: none since INIT
  constexpr bool operator==(const MailboxWindow&) const = default;
};

/// Service bytes that fit into a mailbox of `length` bytes.
[[nodiscard]] constexpr std::size_t service_room(std::uint16_t length) noexcept {
  return length < wire::MailboxHeader::kSize ? 0 : length - wire::MailboxHeader::kSize;
}

}  // namespace driveline::ecat_master
