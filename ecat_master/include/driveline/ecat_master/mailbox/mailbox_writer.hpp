#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/mailbox/mailbox_window.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// The way of one slave's mailboxes to the slave: one mail, written with the same counter until the slave has taken it
/// (ETG.1000.4 5.6), and perhaps the one behind it, which may be on its way before that is known (Relay::next). For
/// MailboxChannel.
class MailboxWriter {
 public:
  /// `window`: of the sync managers that are set up for it.
  MailboxWriter(SlaveRef slave, const MailboxWindow& window);

  /// Service bytes that fit into a mail.
  [[nodiscard]] std::size_t room() const noexcept { return service_room(length_); }
  /// Place for the service of the next mail, room() zeros. The mails before are gone.
  [[nodiscard]] std::span<std::byte> blank();
  /// The same for the mail behind it.
  [[nodiscard]] std::span<std::byte> blank_ahead();
  /// Makes a mail with a new counter of the first `length` bytes of what was blanked last.
  void seal(wire::MailboxType type, std::uint8_t priority, std::size_t length);
  /// There is a mail behind the one that is written.
  [[nodiscard]] bool has_ahead() const noexcept { return ahead_; }
  /// The mail has been taken: the one behind it follows. False: there is none.
  bool advance() noexcept;
  /// Forgets the mail behind.
  void drop_ahead() noexcept { ahead_ = false; }
  /// Appends the datagram that writes the mail.
  void append(std::vector<Request>& batch);
  /// Appends the datagram that writes the mail behind it.
  void append_ahead(std::vector<Request>& batch);

 private:
  [[nodiscard]] std::span<std::byte> blank(std::size_t mail);
  void append(std::size_t mail, std::vector<Request>& batch);

  SlaveRef slave_;
  std::uint16_t address_;
  std::uint16_t length_;
  std::uint8_t counter_;
  std::array<std::vector<std::byte>, 2> mails_;  ///< the mailbox as it is to be written
  std::array<std::vector<std::byte>, 2> wire_;   ///< their copies in datagrams by turns: two may be on their way
  std::size_t current_ = 0;                      ///< of mails_
  std::size_t blanked_ = 0;                      ///< of mails_
  std::size_t side_ = 0;                         ///< of wire_
  bool ahead_ = false;                           ///< the other one of mails_ is behind the current one
};

}  // namespace driveline::ecat_master
