// A slave that puts arbitrary content into its mailbox while the master reads and writes objects and sends and receives
// Ethernet frames. Input: the content of the slave's input mailbox at each read, in pieces after their length in two
// bytes. When it runs out, nothing arrives.

#include <algorithm>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/eoe/eoe_client.hpp"
#include "driveline/ecat_master/eoe/eoe_ports.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

using namespace ecat_master;

constexpr MailboxWindow kWindow{0x1000, 128, 0x1080, 128};

/// The slave end of the mailbox: full as long as there is input.
class LyingSlave final : public DatagramExchange {
 public:
  explicit LyingSlave(std::span<const std::byte> input) : input_(input) {}

  Result<void> exchange(std::span<Request> requests) override {
    for (auto& request : requests) {
      answer(request);
      request.working_counter = 1;
      request.answered = true;
    }
    return {};
  }
  void pause(std::chrono::nanoseconds duration) override { now_ += duration; }
  std::chrono::nanoseconds now() const noexcept override { return now_; }

 private:
  void answer(Request& request) {
    if (request.command != wire::Command::kFprd) return;
    std::fill(request.data.begin(), request.data.end(), std::byte{0});
    if (request.address.ado() != kWindow.in_address) {
      if (input_.size() >= 2) request.data[0] = std::byte{wire::SyncManagerStatus::kMailboxFull};
      return;
    }
    if (input_.size() < 2) return;
    const std::size_t length = std::min<std::size_t>(bytes::load_le<std::uint16_t>(input_), input_.size() - 2);
    std::copy_n(input_.begin() + 2, std::min(length, request.data.size()), request.data.begin());
    input_ = input_.subspan(2 + length);
    now_ += std::chrono::microseconds{1};
  }

  std::span<const std::byte> input_;
  std::chrono::nanoseconds now_{0};
};

/// Receives frames, whose length must be valid for EoE.
class Network final : public EoeReceiver {
 public:
  void receive(std::uint16_t /*position*/, std::span<const std::byte> frame) override {
    if (frame.size() < wire::kMinEoeFrame || frame.size() > wire::kMaxEoeFrame) std::abort();
    for (const auto byte : frame) sum_ += std::to_integer<unsigned>(byte);
  }

 private:
  unsigned sum_ = 0;
};

void append(Bytes& input, std::span<const std::uint8_t> mailbox) {
  const auto length = bytes::to_le_bytes(static_cast<std::uint16_t>(mailbox.size()));
  input.insert(input.end(), length.begin(), length.end());
  for (const auto byte : mailbox) input.push_back(static_cast<std::byte>(byte));
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  LyingSlave slave(input);
  Bus bus(slave);
  EmergencyLog emergencies;
  MailboxClient mailbox(bus, {0, 0x1001}, kWindow);
  mailbox.engine().handle(wire::MailboxType::kCoe, emergencies);
  CoeClient coe(mailbox);
  const Bytes long_value(300, std::byte{0x55});
  const auto name = coe.upload(0x2003, 0);
  if (name && name->size() > CoeClient::kMaxObjectBytes) std::abort();
  static_cast<void>(describe(name ? Error{} : name.error()));
  static_cast<void>(coe.download(0x2003, 0, long_value));
  static_cast<void>(coe.upload_as<std::uint32_t>(0x1018, 1));
  Network network;
  EoePorts ports(mailbox.engine());
  const auto port = ports.open(0, network);
  static_cast<void>(port->send(long_value));
  EoeClient eoe(mailbox.engine(), 0);
  static_cast<void>(eoe.set_ip({.ip = wire::IpV4Address{192, 168, 39, 5}}));
  static_cast<void>(eoe.get_ip());
  static_cast<void>(mailbox.poll());
  if (port->statistics().frames_in > port->statistics().fragments_in) std::abort();
  static_cast<void>(emergencies.take(0));
}

std::vector<Bytes> seeds() {
  // Expedited answer; the first part of ten bytes and the segments with the rest; an emergency; an abort.
  constexpr std::uint8_t kExpedited[] = {10, 0, 0, 0, 0, 0x13, 0, 0x30, 0x43, 0x03, 0x20, 0, 1, 2, 3, 4};
  constexpr std::uint8_t kNormal[] = {12, 0, 0, 0, 0, 0x23, 0, 0x30, 0x41, 0x03, 0x20, 0, 10, 0, 0, 0, 1, 2};
  constexpr std::uint8_t kSegment[] = {10, 0, 0, 0, 0, 0x33, 0, 0x30, 0x00, 3, 4, 5, 6, 7, 8, 9};
  constexpr std::uint8_t kLastSegment[] = {10, 0, 0, 0, 0, 0x43, 0, 0x30, 0x1D, 10, 0, 0, 0, 0, 0, 0};
  constexpr std::uint8_t kEmergency[] = {10, 0, 0, 0, 0, 0x53, 0, 0x10, 0x00, 0xFF, 0x11, 14, 1, 0, 0, 0};
  constexpr std::uint8_t kAbort[] = {10, 0, 0, 0, 0, 0x63, 0, 0x20, 0x80, 0x03, 0x20, 0, 0, 0, 2, 6};
  // A frame of 40 bytes in two fragments, the answers to get IP and set IP, a fragment without the start of its frame.
  constexpr std::uint8_t kHead[] = {36, 0,    0,    0, 0, 0x12, 0, 0, 0x80, 0x10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11,
                                    12, 0x08, 0x06, 0, 0, 0,    0, 0, 0,    0,    0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  0};
  constexpr std::uint8_t kTail[] = {12, 0, 0, 0, 0, 0x22, 0, 1, 0x41, 0x10, 1, 2, 3, 4, 5, 6, 7, 8};
  constexpr std::uint8_t kGetIp[] = {18, 0, 0, 0, 0, 0x32, 7, 1, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0, 0, 5, 5, 39, 168, 192};
  constexpr std::uint8_t kSetIp[] = {4, 0, 0, 0, 0, 0x42, 3, 1, 0, 0};
  constexpr std::uint8_t kStray[] = {8, 0, 0, 0, 0, 0x52, 0, 1, 0x02, 0x20, 1, 2, 3, 4};
  Bytes conversation;
  append(conversation, kEmergency);
  append(conversation, kNormal);
  append(conversation, kSegment);
  append(conversation, kLastSegment);
  append(conversation, kAbort);
  Bytes expedited;
  append(expedited, kExpedited);
  append(expedited, kAbort);
  Bytes ethernet = conversation;
  append(ethernet, kExpedited);
  append(ethernet, kHead);
  append(ethernet, kTail);
  append(ethernet, kGetIp);
  append(ethernet, kSetIp);
  append(ethernet, kStray);
  return {conversation, expedited, ethernet};
}

}  // namespace driveline::fuzz
