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

/// A request to a mailbox protocol.
struct MailboxRequest {
  std::span<const std::byte> data;             ///< service data of the mailbox message
  std::size_t room = 0;                        ///< capacity of the mailbox for service data
  wire::AlState state = wire::AlState::kNone;  ///< AL state of the slave
};

/// A mailbox protocol of a device (CoE, EoE, FoE ...): answers one request at a time.
class MailboxProtocol {
 public:
  virtual ~MailboxProtocol() = default;
  /// Type of the mailbox messages that it answers; constant.
  [[nodiscard]] virtual wire::MailboxType type() const noexcept = 0;
  /// Whether the request has no answer, so that it is handled at once, before any queued request: with an empty output
  /// buffer and state kNone.
  [[nodiscard]] virtual bool without_answer(std::span<const std::byte> /*data*/) const noexcept { return false; }
  /// Whether its unsolicited messages may continue without end. They alternate with all other messages; finite ones
  /// come first.
  [[nodiscard]] virtual bool endless() const noexcept { return false; }
  /// Handles one request and writes the service data of the answer into `out`. Returns the length of the answer, 0 when
  /// the service has none, or the reason why the request is invalid.
  [[nodiscard]] virtual tl::expected<std::size_t, wire::MailboxErrorCode> request(const MailboxRequest& request,
                                                                                  std::span<std::byte> out) = 0;
  /// Writes an unsolicited message (emergency), or the next part of an answer that needs several mailbox messages;
  /// returns 0 when there is none.
  [[nodiscard]] virtual std::size_t unsolicited(std::span<std::byte> out) = 0;
  /// Called when the mailbox is stopped: discards everything in progress.
  virtual void stop() noexcept = 0;
};

/// Mailbox of a slave: checks headers, drops repeated requests, passes the other ones to the protocols and answers with
/// mailbox errors what no protocol can serve (ETG.1000.4 5.6, ETG.1000.6 5.5). An answer has the address of its
/// request, so that a master passes it to the slave that asked; the second and later messages of an answer have address
/// 0.
///
/// Requests are queued until the master has fetched the previous answer, because an answer is composed directly in the
/// mailbox that sends it. Requests without an answer are not queued. No allocation after construction.
class MailboxServer {
 public:
  /// Capacity of the request queue.
  static constexpr std::size_t kQueueDepth = 4;

  /// `max_size`: largest request mailbox in bytes, header included. The protocols must outlive the server.
  MailboxServer(std::span<MailboxProtocol* const> protocols, std::size_t max_size);

  /// Whether request() would accept this mailbox message without losing it to a full queue. \rtsafe
  [[nodiscard]] bool has_room(std::span<const std::byte> mailbox) const noexcept;
  /// Whether a request waits for its answer. \rtsafe
  [[nodiscard]] bool waiting() const noexcept { return count_ != 0; }
  /// Handles a mailbox message that the master wrote, header included.
  void request(std::span<const std::byte> mailbox);
  /// Writes the next mailbox message for the master, header included; returns its length, 0 when there is none.
  [[nodiscard]] std::size_t reply(std::span<std::byte> out, wire::AlState state);
  /// Called when the AL state machine starts or stops the mailbox: discards everything pending.
  void reset() noexcept;

  /// Returns the number of requests lost because the master wrote more than kQueueDepth without fetching an answer and
  /// has_room() was not checked.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
  /// Returns the number of requests recognised as repetitions of the previous one.
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
  [[nodiscard]] std::size_t send(wire::MailboxType type, std::size_t length, std::uint16_t address,
                                 std::span<std::byte> out);
  [[nodiscard]] std::size_t send_error(wire::MailboxErrorCode code, std::uint16_t address, std::span<std::byte> out);
  [[nodiscard]] MailboxProtocol* protocol(wire::MailboxType type) const noexcept;

  std::vector<MailboxProtocol*> protocols_;
  std::array<Request, kQueueDepth> queue_;
  std::size_t head_ = 0;
  std::size_t count_ = 0;
  std::uint8_t last_counter_ = 0;
  std::uint8_t counter_ = 0;
  bool endless_next_ = false;  ///< the next message comes from an endless() protocol, if it has one
  std::uint64_t dropped_ = 0;
  std::uint64_t repeated_ = 0;
};

}  // namespace driveline::slaves
