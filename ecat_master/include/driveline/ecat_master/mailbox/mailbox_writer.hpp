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

/// The sending side of a slave's mailboxes: writes one message with the same counter until the slave has taken it
/// (ETG.1000.4 5.6), and possibly the next message, which may be sent before that is known (Relay::next). Used by
/// MailboxChannel.
class MailboxWriter {
 public:
  /// `window`: mailboxes for which the sync managers are set up.
  MailboxWriter(SlaveRef slave, const MailboxWindow& window);

  /// Service bytes that fit into a message.
  [[nodiscard]] std::size_t room() const noexcept { return service_room(length_); }
  /// Buffer for the service of the next message, room() zeros. Discards the previous messages.
  [[nodiscard]] std::span<std::byte> blank();
  /// Buffer for the service of the message after it, room() zeros.
  [[nodiscard]] std::span<std::byte> blank_ahead();
  /// Makes a message with a new counter from the first `length` bytes of the last buffer returned. `source`: station
  /// address of the slave that it comes from; 0: the master.
  void seal(wire::MailboxType type, std::uint8_t priority, std::size_t length, std::uint16_t source = 0);
  /// Like seal(), but with the counter of the previous message: a slave that has taken that one drops this one.
  void seal_again(wire::MailboxType type, std::uint8_t priority, std::size_t length, std::uint16_t source = 0);
  /// Counter of the last sealed message.
  [[nodiscard]] std::uint8_t counter() const noexcept { return counter_; }
  /// Whether there is a message after the current one.
  [[nodiscard]] bool has_ahead() const noexcept { return ahead_; }
  /// The current message has been taken: continues with the next one. Returns false when there is none.
  bool advance() noexcept;
  /// Discards the message after the current one.
  void drop_ahead() noexcept { ahead_ = false; }
  /// Appends the datagram that writes the current message.
  void append(std::vector<Request>& batch);
  /// Appends the datagram that writes the message after it.
  void append_ahead(std::vector<Request>& batch);

 private:
  [[nodiscard]] std::span<std::byte> blank(std::size_t mail);
  void append(std::size_t mail, std::vector<Request>& batch);

  SlaveRef slave_;
  std::uint16_t address_;
  std::uint16_t length_;
  std::uint8_t counter_;
  std::array<std::vector<std::byte>, 2> mails_;  ///< mailbox contents to be written
  std::array<std::vector<std::byte>, 2>
      wire_;                 ///< copies of mails_ in datagrams, used alternately: two may be in flight
  std::size_t current_ = 0;  ///< index into mails_
  std::size_t blanked_ = 0;  ///< index into mails_
  std::size_t side_ = 0;     ///< index into wire_
  bool ahead_ = false;       ///< the other element of mails_ follows the current one
};

}  // namespace driveline::ecat_master
