#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue.hpp"

namespace driveline::ecat_master {

/// A service of any protocol as it is, and the answer as it is: for protocols that mean something to the caller alone
/// (VoE), and for services that come from elsewhere (a mailbox gateway). An answer of several mails (the lists of CoE
/// and fragments of SoE say that more follows) is complete in answers(); an emergency is no answer.
class MailExchange final : public MailboxDialogue {
 public:
  /// Sends `service`, the bytes behind the mailbox header. `patience`: for each mail of the answer; none: nobody
  /// answers this service, and it is done when the slave has taken it.
  MailExchange(wire::MailboxType type, std::vector<std::byte> service,
               std::optional<std::chrono::nanoseconds> patience);

  /// After done(): service bytes that fit into a mail of the slave; 0: it was never sent.
  [[nodiscard]] std::size_t answer_room() const noexcept { return answer_room_; }
  /// After done(): the services of the answer, at least one unless nobody answers. Errors: Mailbox*, ProcessDataSize
  /// (longer than the mailbox), those of the bus.
  [[nodiscard]] const Result<std::vector<std::vector<std::byte>>>& answers() const noexcept { return answers_; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return service_; }
  [[nodiscard]] std::optional<std::chrono::nanoseconds> patience() const noexcept override { return patience_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return patience_.has_value(); }
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) override;
  void fail(const Error& error) override { answers_ = tl::unexpected(error); }

 private:
  std::vector<std::byte> service_;
  std::optional<std::chrono::nanoseconds> patience_;
  std::size_t answer_room_ = 0;
  Result<std::vector<std::vector<std::byte>>> answers_;
};

}  // namespace driveline::ecat_master
