#include "driveline/ecat_master/mailbox/mailbox_client.hpp"

namespace driveline::ecat_master {
namespace {

/// A service without an answer.
class Message final : public MailboxDialogue {
 public:
  Message(wire::MailboxType type, std::span<const std::byte> service)
      : MailboxDialogue(type, 0), service_(service.begin(), service.end()) {}

  void begin(std::uint16_t /*position*/, MailboxRoom /*room*/) override {}
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return service_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return false; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> /*service*/) override { return Reaction::kForeign; }
  void fail(const Error& error) override { result = tl::unexpected(error); }

  Result<void> result;

 private:
  std::vector<std::byte> service_;
};

}  // namespace

MailboxClient::MailboxClient(MailboxEngine& engine, SlaveRef slave, MailboxWindow window)
    : engine_(&engine), slave_(slave) {
  engine_->open(slave, window);
}

MailboxClient::MailboxClient(Bus& bus, SlaveRef slave, MailboxWindow window)
    : own_engine_(std::make_unique<MailboxEngine>(bus)), engine_(own_engine_.get()), slave_(slave) {
  engine_->open(slave, window);
}

Result<void> MailboxClient::send(wire::MailboxType type, std::span<const std::byte> service) {
  auto message = std::make_shared<Message>(type, service);
  engine_->submit(slave_.position, message);
  engine_->wait(*message);
  return message->result;
}

}  // namespace driveline::ecat_master
