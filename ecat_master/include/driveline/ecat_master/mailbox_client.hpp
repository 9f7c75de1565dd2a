#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <vector>

#include "driveline/ecat_master/bus.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {

/// Where a slave has its mailboxes: sync manager 0 (to the slave) and 1 (from the slave).
struct MailboxWindow {
  std::uint16_t out_address = 0;
  std::uint16_t out_length = 0;
  std::uint16_t in_address = 0;
  std::uint16_t in_length = 0;
};

/// The mailbox of one slave, seen from the master: counter, waiting for the reply by polling the sync manager's
/// status, repetition of a reply that was lost on the wire (ETG.1000.4 5.6, repeat request and acknowledge).
///
/// Messages that arrive ahead of the reply are no answers: CoE emergencies are collected, the rest is dropped.
/// Not real-time safe; one thread at a time.
class MailboxClient {
 public:
  /// Most emergencies kept; the oldest goes first.
  static constexpr std::size_t kMaxEmergencies = 64;
  static constexpr std::chrono::nanoseconds kReplyTimeout = std::chrono::seconds{2};

  MailboxClient(Bus& bus, SlaveRef slave, MailboxWindow window) : bus_(bus), slave_(slave), window_(window) {}

  /// Decides whether service data of the requested type is the awaited reply.
  using IsReply = std::function<bool(std::span<const std::byte>)>;

  /// Sends `service` (the bytes behind the mailbox header) and returns the service data of the reply.
  /// Errors: kMailboxTimeout, kMailboxError (code: detail), kMailboxMalformed, kProcessDataSize (service longer than
  /// the mailbox), those of the bus.
  [[nodiscard]] Result<std::vector<std::byte>> transact(wire::MailboxType type, std::span<const std::byte> service,
                                                        const IsReply& is_reply);

  /// Sends without waiting for an answer (SDO abort).
  [[nodiscard]] Result<void> send(wire::MailboxType type, std::span<const std::byte> service);

  /// Fetches what the slave has put into its mailbox by itself, e.g. emergencies.
  [[nodiscard]] Result<void> poll();

  /// Emergencies that have arrived so far, oldest first; the call empties the list.
  [[nodiscard]] std::vector<wire::Emergency> take_emergencies();

  [[nodiscard]] SlaveRef slave() const noexcept { return slave_; }
  /// Service bytes that fit into one mailbox to the slave.
  [[nodiscard]] std::size_t max_service() const noexcept { return window_.out_length - wire::MailboxHeader::kSize; }

 private:
  struct Mail {
    wire::MailboxHeader header;
    std::vector<std::byte> service;
  };
  [[nodiscard]] Result<bool> fetch(Mail& mail);
  [[nodiscard]] Result<void> read_full_mailbox(std::span<std::byte> data);
  [[nodiscard]] Result<void> request_repeat(std::chrono::nanoseconds deadline);
  void collect(const Mail& mail);
  [[nodiscard]] Error error(ErrorKind kind, std::uint32_t code = 0) const noexcept;

  Bus& bus_;
  SlaveRef slave_;
  MailboxWindow window_;
  std::uint8_t counter_ = 0;
  std::uint8_t last_received_ = 0;
  std::deque<wire::Emergency> emergencies_;
};

}  // namespace driveline::ecat_master
