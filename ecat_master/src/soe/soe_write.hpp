#pragma once

#include <memory>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/ecat_master/soe/soe_transfer.hpp"

namespace driveline::ecat_master {

/// Priority of the dialogues that must follow the first fragment of a write: ahead of all other SoE dialogues of the
/// slave, which have the lowest priority.
inline constexpr std::uint8_t kSoeFollowingPriority = 3;

/// A fragment of a write except the last. The write itself receives the answer to all fragments, because servers answer
/// only the last message.
class SoeFragment : public MailboxDialogue {
 public:
  SoeFragment(std::shared_ptr<SoeTransfer> write, std::vector<std::byte> service, std::uint8_t priority);

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept final { return service_; }
  [[nodiscard]] bool awaits_answer() const noexcept final { return false; }
  /// An early answer is a refusal, or confirms a fragment.
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) final;
  void fail(const Error& error) override { write_->abandon(error); }

 protected:
  std::shared_ptr<SoeTransfer> write_;
  std::vector<std::byte> service_;
};

/// Starts a write: splits it once the room of the mailbox is known, and queues the following fragments before any other
/// SoE dialogue can intervene.
class SoeWriteBeginning final : public SoeFragment {
 public:
  /// `write` has kSoeFollowingPriority.
  SoeWriteBeginning(MailboxEngine& engine, std::shared_ptr<SoeTransfer> write);

  void begin(std::uint16_t position, MailboxRoom room) override;
  void fail(const Error& error) override;
  void completed() override;

 private:
  MailboxEngine& engine_;
  bool begun_ = false;
  bool alone_ = false;  ///< the write fits into one message
};

}  // namespace driveline::ecat_master
