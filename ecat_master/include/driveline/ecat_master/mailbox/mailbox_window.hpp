#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Patience with the mailboxes of one slave; none: as for all (MailboxChannel::Settings).
struct MailboxTimeouts {
  std::optional<std::chrono::nanoseconds> request;   ///< until it takes a mailbox
  std::optional<std::chrono::nanoseconds> response;  ///< until it answers
  constexpr bool operator==(const MailboxTimeouts&) const = default;
};

/// Where a slave has its mailboxes: sync manager 0 (to the slave) and 1 (from the slave).
struct MailboxWindow {
  std::uint16_t out_address = 0;  ///< of the master's mails, in the slave's memory
  std::uint16_t out_length = 0;   ///< bytes
  std::uint16_t in_address = 0;   ///< of the slave's mails, in the slave's memory
  std::uint16_t in_length = 0;    ///< bytes
  MailboxTimeouts timeouts{};     ///< of this slave
  std::uint8_t last_counter = 0;  ///< of the last mail it has had, 1 to 7; 0: none since INIT
  constexpr bool operator==(const MailboxWindow&) const = default;
};

/// Service bytes that fit into a mailbox of `length` bytes.
[[nodiscard]] constexpr std::size_t service_room(std::uint16_t length) noexcept {
  return length < wire::MailboxHeader::kSize ? 0 : length - wire::MailboxHeader::kSize;
}

}  // namespace driveline::ecat_master
