#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/mailbox/mailbox_window.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// The way of one slave's mailboxes to the slave: one mail, written with the same counter until the slave has taken it
/// (ETG.1000.4 5.6). For MailboxChannel.
class MailboxWriter {
 public:
  /// `window`: of the sync managers that are set up for it.
  MailboxWriter(SlaveRef slave, const MailboxWindow& window);

  /// Service bytes that fit into a mail.
  [[nodiscard]] std::size_t room() const noexcept { return service_room(length_); }
  /// Place for the service of the next mail, room() zeros. The mail before is gone.
  [[nodiscard]] std::span<std::byte> blank();
  /// Makes a mail with a new counter of the first `length` bytes of blank().
  void seal(wire::MailboxType type, std::uint8_t priority, std::size_t length);
  /// Appends the datagram that writes the mail.
  void append(std::vector<Request>& batch);

 private:
  SlaveRef slave_;
  std::uint16_t address_;
  std::uint16_t length_;
  std::uint8_t counter_;
  std::vector<std::byte> mail_;  ///< the mailbox as it is to be written
  std::vector<std::byte> wire_;  ///< its copy in the datagram
};

}  // namespace driveline::ecat_master
