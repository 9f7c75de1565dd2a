#pragma once

#include <memory>

#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"
#include "driveline/ecat_master/soe/soe_transfer.hpp"

namespace driveline::ecat_master {

/// Priority of what must follow the first fragment of a write: ahead of every other SoE dialogue of the slave, which
/// have the lowest.
inline constexpr std::uint8_t kSoeFollowingPriority = 3;

/// A fragment ahead of the end of a write, which takes the answer to all of them. Servers answer the last mail alone.
class SoeFragment : public MailboxDialogue {
 public:
  SoeFragment(std::shared_ptr<SoeTransfer> write, std::vector<std::byte> service, std::uint8_t priority);

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept final { return service_; }
  [[nodiscard]] bool awaits_answer() const noexcept final { return false; }
  /// An answer ahead of its time is a refusal, or confirms a fragment.
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) final;
  void fail(const Error& error) override { write_->abandon(error); }

 protected:
  std::shared_ptr<SoeTransfer> write_;
  std::vector<std::byte> service_;
};

/// Begins a write: takes it apart once the room of the mailbox is known, and queues what follows before anything else
/// of SoE can come in between.
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
  bool alone_ = false;  ///< the write needs no fragments ahead
};

}  // namespace driveline::ecat_master
