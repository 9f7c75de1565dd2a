#include "soe/soe_write.hpp"

#include <utility>

namespace driveline::ecat_master {

SoeFragment::SoeFragment(std::shared_ptr<SoeTransfer> write, std::vector<std::byte> service, std::uint8_t priority)
    : MailboxDialogue(wire::MailboxType::kSoe, priority), write_(std::move(write)), service_(std::move(service)) {}

void SoeFragment::begin(std::uint16_t /*position*/, MailboxRoom room) {
  // Make it too large for the mailbox, so that it is refused and not sent.
  if (write_->failed()) service_.resize(room.out + 1);
}

MailboxDialogue::Reaction SoeFragment::receive(std::span<const std::byte> service) {
  const auto header = wire::SoeHeader::decode(service);
  if (!header || header->op_code != wire::SoeOpCode::kWriteResponse || !header->error) return Reaction::kForeign;
  static_cast<void>(write_->receive(service));
  return Reaction::kDone;
}

SoeWriteBeginning::SoeWriteBeginning(MailboxEngine& engine, std::shared_ptr<SoeTransfer> write)
    : SoeFragment(std::move(write), {}, 0), engine_(engine) {}

void SoeWriteBeginning::begin(std::uint16_t position, MailboxRoom room) {
  begun_ = true;
  auto services = write_->split(position, room.out);
  alone_ = services.empty();
  if (alone_) {
    // The whole write fits into one message: make this one too large, so that it is refused and not sent.
    service_.resize(room.out + 1);
  } else {
    service_ = std::move(services.front());
  }
  for (std::size_t i = 1; i < services.size(); ++i) {
    engine_.submit(position, std::make_shared<SoeFragment>(write_, std::move(services[i]), kSoeFollowingPriority));
  }
  engine_.submit(position, write_);
}

void SoeWriteBeginning::fail(const Error& error) {
  if (!alone_) write_->abandon(error);
}

void SoeWriteBeginning::completed() {
  if (!begun_) write_->complete();
}

}  // namespace driveline::ecat_master
