#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Mails of one protocol to one slave that await no answers, beside its dialogues: a source that MailboxChannel pulls
/// from whenever no dialogue has anything to send. What the slave sends in this protocol goes to the protocol's handler
/// (MailboxEngine::handle()).
///
/// All functions are called by the thread that steps the engine or opens and closes its mailboxes, never by two at
/// once; they must not call the engine back.
class MailboxStream {
 public:
  virtual ~MailboxStream() = default;
  /// Protocol of its mails.
  [[nodiscard]] virtual wire::MailboxType type() const noexcept = 0;
  /// The mailboxes have been opened, perhaps anew: the slave knows nothing of what was before. `room`: service bytes
  /// that fit into a mail to the slave.
  virtual void opened(std::size_t room) = 0;
  /// The mailboxes have been closed; nothing is pulled until they are opened again.
  virtual void closed() = 0;
  /// Writes the next service into `out` and returns its length; 0: there is none now. The mail is carried until it is
  /// taken() or given_up(); at most kMostOpen are on their way.
  [[nodiscard]] virtual std::size_t next(std::span<std::byte> out) = 0;
  /// Mails that next() may be asked for before the slave has taken the first of them.
  static constexpr std::size_t kMostOpen = 2;
  /// Mails of the slave that certainly come, behind those that the handler has had.
  [[nodiscard]] virtual std::size_t expected() const = 0;
  /// The slave has taken the oldest of the mails that are on their way.
  virtual void taken() = 0;
  /// The slave has not taken a mail in time; nobody will send it again, nor those behind it.
  virtual void given_up() = 0;
};

}  // namespace driveline::ecat_master
