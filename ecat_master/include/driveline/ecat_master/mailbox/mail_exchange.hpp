#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue.hpp"

namespace driveline::ecat_master {

/// Exchanges raw services of any protocol: for protocols known only to the caller (VoE), and for services from
/// elsewhere (a mailbox gateway). An answer of several messages (lists of CoE and fragments of SoE announce further
/// messages) is complete in answers(); an emergency or a request of the slave is not an answer.
class MailExchange final : public MailboxDialogue {
 public:
  /// Bytes that a message takes in addition to its content.
  static constexpr std::size_t kBytesPerMessage = sizeof(std::vector<std::byte>);
  /// Most bytes that the messages of one answer may take, more than the longest list of CoE or SoE. Without a limit, a
  /// slave that announces further messages again and again would fill the memory.
  static constexpr std::size_t kLargest = std::size_t{4} << 20;

  /// Sends `service`, the bytes behind the mailbox header. `timeout`: time-out of each message of the answer; empty:
  /// the service has no answer, and the exchange is done when the slave has taken it.
  MailExchange(wire::MailboxType type, std::vector<std::byte> service, std::optional<std::chrono::nanoseconds> timeout);

  /// After done(): service bytes that fit into a message from the slave; 0: the service was never sent.
  [[nodiscard]] std::size_t answer_room() const noexcept { return answer_room_; }
  /// After done(): the services of the answer, at least one unless the service has no answer. Errors: Mailbox*
  /// (MailboxMalformed: the answer exceeds kLargest), ProcessDataSize (longer than the mailbox), those of the bus.
  [[nodiscard]] const Result<std::vector<std::vector<std::byte>>>& answers() const noexcept { return answers_; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return service_; }
  [[nodiscard]] std::optional<std::chrono::nanoseconds> timeout() const noexcept override { return timeout_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return timeout_.has_value(); }
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) override;
  void fail(const Error& error) override { answers_ = tl::unexpected(error); }

 private:
  std::vector<std::byte> service_;
  std::optional<std::chrono::nanoseconds> timeout_;
  std::size_t answer_room_ = 0;
  std::size_t kept_bytes_ = 0;  ///< memory of `answers_`
  std::uint16_t position_ = Error::kNoSlave;
  Result<std::vector<std::vector<std::byte>>> answers_;
};

}  // namespace driveline::ecat_master
