#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/wire/al.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::slaves {

/// What a mailbox protocol is asked.
struct MailboxRequest {
  std::span<const std::byte> data;             ///< service data of the mail
  std::size_t room = 0;                        ///< most that would have fitted into the mailbox
  wire::AlState state = wire::AlState::kNone;  ///< of the slave
};

/// A mailbox protocol of a device (CoE, EoE, FoE): answers one request at a time.
class MailboxProtocol {
 public:
  virtual ~MailboxProtocol() = default;
  /// Type of the mailboxes it answers; stays the same.
  [[nodiscard]] virtual wire::MailboxType type() const noexcept = 0;
  /// The request has no answer, so that it is handled as soon as it comes, whatever waits: with nothing to write into
  /// and with state kNone.
  [[nodiscard]] virtual bool without_answer(std::span<const std::byte> /*data*/) const noexcept { return false; }
  /// What it says unasked may go on for ever. It takes turns with everything else; what has an end comes first.
  [[nodiscard]] virtual bool endless() const noexcept { return false; }
  /// Handles one request and writes the service data of the answer into `out`. Returns the
  /// length of the answer, 0 when the service has none, or the reason why the request is not understood.
  [[nodiscard]] virtual tl::expected<std::size_t, wire::MailboxErrorCode> request(const MailboxRequest& request,
                                                                                  std::span<std::byte> out) = 0;
  /// Something the protocol has to say unasked (emergencies), or the rest of an answer that takes several mailboxes;
  /// 0 when there is nothing.
  [[nodiscard]] virtual std::size_t unsolicited(std::span<std::byte> out) = 0;
  /// The mailbox was stopped: forget what is in progress.
  virtual void stop() noexcept = 0;
};

/// Mailbox of a slave: checks headers, drops repeated requests, hands the rest to the protocols and answers what it
/// cannot serve with mailbox errors (ETG.1000.4 5.6, ETG.1000.6 5.5).
///
/// Requests wait in a queue until the master has fetched the previous answer, because an answer is made directly in
/// the mailbox it leaves in. Those without an answer wait for nothing. No allocation after construction.
class MailboxServer {
 public:
  /// Requests that may wait for their turn.
  static constexpr std::size_t kQueueDepth = 4;

  /// `max_size`: largest request mailbox in bytes, header included. The protocols must outlive the server.
  MailboxServer(std::span<MailboxProtocol* const> protocols, std::size_t max_size);

  /// request() would not lose this mailbox for want of room in the queue. \rtsafe
  [[nodiscard]] bool has_room(std::span<const std::byte> mailbox) const noexcept;
  /// A mailbox the master wrote, header included.
  void request(std::span<const std::byte> mailbox);
  /// Next mailbox for the master, header included; returns its length, 0 when there is none.
  [[nodiscard]] std::size_t reply(std::span<std::byte> out, wire::AlState state);
  /// The mailbox was started or stopped by the AL state machine: everything pending is forgotten.
  void reset() noexcept;

  /// Requests lost because the master wrote more than kQueueDepth without fetching an answer, and nobody has asked
  /// has_room().
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
  /// Requests recognised as repetitions of the one before.
  [[nodiscard]] std::uint64_t repeated() const noexcept { return repeated_; }

 private:
  struct Request {
    wire::MailboxHeader header;
    std::optional<wire::MailboxErrorCode> error;
    std::vector<std::byte> data;
    std::uint16_t length = 0;
    std::uint16_t room = 0;
  };
  [[nodiscard]] bool repeats(std::span<const std::byte> mailbox) const noexcept;
  [[nodiscard]] MailboxProtocol* unanswering(std::span<const std::byte> mailbox) const noexcept;
  [[nodiscard]] std::size_t say_unasked(bool endless, std::span<std::byte> out);
  [[nodiscard]] std::size_t answer_next(wire::AlState state, std::span<std::byte> out);
  [[nodiscard]] std::size_t answer(const Request& request, wire::AlState state, std::span<std::byte> out);
  [[nodiscard]] std::size_t send(wire::MailboxType type, std::size_t length, std::span<std::byte> out);
  [[nodiscard]] std::size_t send_error(wire::MailboxErrorCode code, std::span<std::byte> out);
  [[nodiscard]] MailboxProtocol* protocol(wire::MailboxType type) const noexcept;

  std::vector<MailboxProtocol*> protocols_;
  std::array<Request, kQueueDepth> queue_;
  std::size_t head_ = 0;
  std::size_t count_ = 0;
  std::uint8_t last_counter_ = 0;
  std::uint8_t counter_ = 0;
  bool endless_next_ = false;  ///< the turn is that of what goes on for ever
  std::uint64_t dropped_ = 0;
  std::uint64_t repeated_ = 0;
};

}  // namespace driveline::slaves
