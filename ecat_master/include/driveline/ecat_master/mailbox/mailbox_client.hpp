#pragma once

#include <memory>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"

namespace driveline::ecat_master {

/// The mailbox of one slave for callers that wait: a view of the slave's channel in the engine of the line. Any
/// ordinary thread; not \rtsafe.
class MailboxClient {
 public:
  /// How long an answer may take unless told otherwise.
  static constexpr std::chrono::nanoseconds kReplyTimeout = MailboxEngine::Settings{}.reply_timeout;

  /// Opens the mailboxes of `slave` in `engine`, which must outlive the client.
  MailboxClient(MailboxEngine& engine, SlaveRef slave, MailboxWindow window);
  /// With an engine of its own, for tools that talk to a single slave.
  MailboxClient(Bus& bus, SlaveRef slave, MailboxWindow window);

  /// Hands `service` (the bytes behind the mailbox header) over without waiting for an answer. Errors: MailboxTimeout,
  /// ProcessDataSize (service longer than the mailbox), those of the bus.
  [[nodiscard]] Result<void> send(wire::MailboxType type, std::span<const std::byte> service);

  /// Fetches what the slave has put into its mailbox by itself, e.g. emergencies.
  [[nodiscard]] Result<void> poll() { return engine_->poll(slave_.position); }

  /// Whose mailboxes these are.
  [[nodiscard]] SlaveRef slave() const noexcept { return slave_; }
  /// That serves them.
  [[nodiscard]] MailboxEngine& engine() noexcept { return *engine_; }

 private:
  std::unique_ptr<MailboxEngine> own_engine_;
  MailboxEngine* engine_;
  SlaveRef slave_;
};

}  // namespace driveline::ecat_master
