#pragma once

#include <memory>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"

namespace driveline::ecat_master {

/// The mailbox of a slave as blocking calls: a view of the slave's channel in the engine of the line. Any ordinary
/// thread; not \rtsafe.
class MailboxClient {
 public:
  /// Default time-out of an answer.
  static constexpr std::chrono::nanoseconds kReplyTimeout = MailboxEngine::Settings{}.reply_timeout;

  /// Opens the mailboxes of `slave` in `engine`, which must outlive the client.
  MailboxClient(MailboxEngine& engine, SlaveRef slave, MailboxWindow window);
  /// With its own engine, for tools that access a single slave.
  MailboxClient(Bus& bus, SlaveRef slave, MailboxWindow window);

  /// Hands `service` (the bytes behind the mailbox header) to the slave without waiting for an answer. Errors:
  /// MailboxTimeout, ProcessDataSize (service longer than the mailbox), those of the bus.
  [[nodiscard]] Result<void> send(wire::MailboxType type, std::span<const std::byte> service);

  /// Fetches unsolicited messages from the slave's mailbox, e.g. emergencies.
  [[nodiscard]] Result<void> poll() { return engine_->poll(slave_.position); }

  /// The slave of these mailboxes.
  [[nodiscard]] SlaveRef slave() const noexcept { return slave_; }
  /// The engine that serves the mailboxes.
  [[nodiscard]] MailboxEngine& engine() noexcept { return *engine_; }

 private:
  std::unique_ptr<MailboxEngine> own_engine_;
  MailboxEngine* engine_;
  SlaveRef slave_;
};

}  // namespace driveline::ecat_master
