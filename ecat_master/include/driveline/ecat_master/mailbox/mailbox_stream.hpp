#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Messages of a protocol to a slave that expect no answers, in addition to its dialogues: MailboxChannel pulls them
/// whenever no dialogue has anything to send. Messages from the slave in this protocol go to the protocol's handler
/// (MailboxEngine::handle()).
///
/// All functions are called by the thread that steps the engine or opens and closes its mailboxes, never by two threads
/// at once; they must not call the engine.
class MailboxStream {
 public:
  virtual ~MailboxStream() = default;
  /// Protocol of its messages.
  [[nodiscard]] virtual wire::MailboxType type() const noexcept = 0;
  /// The mailboxes have been opened or reopened: the slave has no knowledge of earlier messages. `room`: service bytes
  /// that fit into a message to the slave.
  virtual void opened(std::size_t room) = 0;
  /// The mailboxes have been closed; no messages are pulled until they are opened again.
  virtual void closed() = 0;
  /// Writes the next service into `out` and returns its length; 0: none now. The message is pending until taken() or
  /// given_up(); at most kMaxOpen are pending.
  [[nodiscard]] virtual std::size_t next(std::span<std::byte> out) = 0;
  /// Most messages that next() may provide before the slave has taken the first of them.
  static constexpr std::size_t kMaxOpen = 2;
  /// Number of messages from the slave that will certainly follow those already passed to the handler.
  [[nodiscard]] virtual std::size_t expected() const = 0;
  /// The slave has taken the oldest pending message.
  virtual void taken() = 0;
  /// The slave did not take a message in time; neither it nor the following pending messages will be sent again.
  virtual void given_up() = 0;
};

}  // namespace driveline::ecat_master
