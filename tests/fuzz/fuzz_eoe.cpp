// Ethernet over EtherCAT of a drive. Input: consecutive EoE services, each after its length in two bytes; every second
// frame that they contain is returned by the network.

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>
#include <vector>

#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/eoe_frames.hpp"
#include "driveline/wire/mailbox.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

/// Returns the received frames, as long as it has room for them.
class Mirror final : public slaves::EthernetLink {
 public:
  bool send(std::span<const std::byte> frame) noexcept override {
    if (frame.size() < wire::kMinEoeFrame || frame.size() > frame_.size()) std::abort();
    if (length_ != 0) return false;
    length_ = frame.size();
    std::copy(frame.begin(), frame.end(), frame_.begin());
    return true;
  }
  std::size_t receive(std::span<std::byte> out) noexcept override {
    if (length_ > out.size()) std::abort();
    std::copy_n(frame_.begin(), length_, out.begin());
    return std::exchange(length_, 0);
  }
  void set_address(const wire::EoeIpParameters& address) noexcept override {
    if (!address.mac || !address.ip || !address.subnet_mask) std::abort();
  }
  void set_link(bool up) noexcept override {
    if (!up) length_ = 0;
  }

 private:
  std::array<std::byte, wire::kMaxEoeFrame> frame_{};
  std::size_t length_ = 0;
};

void talk(std::span<const std::byte> input, std::size_t mailbox_bytes) {
  slaves::msd::MsdDrive drive;
  Mirror network;
  static_cast<void>(drive.connect_network(&network));
  static_cast<void>(drive.transition(wire::AlState::kInit, wire::AlState::kPreOp));
  std::vector<std::byte> mailbox(mailbox_bytes);
  std::vector<std::byte> reply(mailbox_bytes);
  while (input.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(bytes::load_le<std::uint16_t>(input), input.size() - 2);
    std::fill(mailbox.begin(), mailbox.end(), std::byte{0});
    wire::MailboxHeader header;
    header.length = static_cast<std::uint16_t>(std::min(length, mailbox.size() - wire::MailboxHeader::kSize));
    header.type = wire::MailboxType::kEoe;
    header.encode(std::span(mailbox).first<wire::MailboxHeader::kSize>());
    std::copy_n(input.begin() + 2, header.length, mailbox.begin() + wire::MailboxHeader::kSize);
    input = input.subspan(2 + length);
    if (drive.takes_mailbox(mailbox)) drive.mailbox_request(mailbox);
    const auto bytes = drive.mailbox_reply(reply);
    if (bytes > reply.size()) std::abort();
    if (bytes > 0 && !wire::MailboxHeader::decode(std::span(reply).first(bytes))) std::abort();
  }
  if (drive.mailbox().dropped() != 0) std::abort();
}

void append(Bytes& input, std::span<const std::byte> service) {
  const auto length = bytes::to_le_bytes(static_cast<std::uint16_t>(service.size()));
  input.insert(input.end(), length.begin(), length.end());
  input.insert(input.end(), service.begin(), service.end());
}

Bytes service(wire::EoeType type, std::size_t content) {
  Bytes bytes(wire::EoeHeader::kSize + content);
  wire::EoeHeader header;
  header.type = type;
  header.last_fragment = true;
  header.encode(std::span(bytes).first<wire::EoeHeader::kSize>());
  return bytes;
}

Bytes frames() {
  Bytes input;
  const Bytes frame(700, std::byte{0x5A});
  wire::EoeFragmenter fragmenter;
  for (int i = 0; i < 3; ++i) {
    if (!fragmenter.begin(frame)) std::abort();
    while (!fragmenter.done()) {
      std::array<std::byte, 250> mail{};
      append(input, std::span(mail).first(fragmenter.next(mail)));
    }
  }
  return input;
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  for (const std::size_t mailbox : {48U, 128U, 512U}) talk(input, mailbox);
}

std::vector<Bytes> seeds() {
  using wire::EoeType;
  Bytes services;
  auto address = service(EoeType::kSetIpRequest, wire::EoeIpParameters::kSize);
  wire::EoeIpParameters parameters = slaves::factory_address(1);
  parameters.encode(std::span(address).subspan<wire::EoeHeader::kSize, wire::EoeIpParameters::kSize>());
  append(services, address);
  append(services, service(EoeType::kGetIpRequest, 0));
  append(services, service(EoeType::kSetFilterRequest, wire::EoeAddressFilter::kSize));
  append(services, service(EoeType::kGetFilterRequest, 0));
  append(services, service(static_cast<EoeType>(12), 3));
  return {services, frames()};
}

}  // namespace driveline::fuzz
