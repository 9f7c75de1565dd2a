// File access over EtherCAT, both ends. Input: consecutive FoE services, each after its length in two bytes. They go to
// the drive in BOOT and in PREOP, and to a master that reads a file or writes one.

#include <algorithm>
#include <array>

#include "driveline/ecat_master/foe/file_transfer.hpp"
#include "driveline/slaves/msd/core/firmware_image.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/mailbox.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

using ecat_master::FileTransfer;
using ecat_master::MailboxDialogue;

constexpr std::size_t kMailboxBytes = 512;
constexpr std::size_t kRoom = 64;

template <typename Take>
void for_each_service(std::span<const std::byte> input, Take&& take) {
  while (input.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(bytes::load_le<std::uint16_t>(input), input.size() - 2);
    take(input.subspan(2, length));
    input = input.subspan(2 + length);
  }
}

void talk_to_drive(std::span<const std::byte> input, wire::AlState state) {
  slaves::msd::MsdDrive drive;
  static_cast<void>(drive.transition(wire::AlState::kInit, state));
  const auto firmware = drive.core().firmware();
  std::chrono::nanoseconds now{0};
  std::array<std::byte, kMailboxBytes> reply{};
  for_each_service(input, [&](std::span<const std::byte> service) {
    std::array<std::byte, kMailboxBytes> mailbox{};
    wire::MailboxHeader header;
    header.length = static_cast<std::uint16_t>(std::min(service.size(), mailbox.size() - wire::MailboxHeader::kSize));
    header.type = wire::MailboxType::kFoe;
    header.encode(std::span(mailbox).first<wire::MailboxHeader::kSize>());
    std::copy_n(service.begin(), header.length, mailbox.begin() + wire::MailboxHeader::kSize);
    drive.mailbox_request(mailbox);
    const auto bytes = drive.mailbox_reply(reply);
    if (bytes > reply.size()) std::abort();
    if (bytes > 0 && !wire::MailboxHeader::decode(std::span(reply).first(bytes))) std::abort();
    now += drive.process_data_period();
    drive.advance(now);
  });
  if (drive.core().firmware() != firmware) std::abort();  // not before the restart
  // An accepted parameter set must leave a drive that starts.
  drive.restart();
  drive.advance(now + std::chrono::milliseconds{5});
}

/// The master sends as long as it needs; the input contains the answers.
void talk_to_master(std::span<const std::byte> input, FileTransfer& transfer) {
  bool open = true;
  transfer.begin(0, {kRoom, kRoom});
  for_each_service(input, [&](std::span<const std::byte> service) {
    if (!open) return;
    const auto reaction = transfer.receive(service.first(std::min(service.size(), kRoom)));
    open = reaction != MailboxDialogue::Reaction::kDone && transfer.awaits_answer();
    if (transfer.outgoing().size() > kRoom) std::abort();
  });
  if (open) transfer.fail({ecat_master::facts::MailboxTimeout{}, 0});
  static_cast<void>(transfer.result().has_value());
}

void append(Bytes& input, std::span<const std::byte> service) {
  const auto length = bytes::to_le_bytes(static_cast<std::uint16_t>(service.size()));
  input.insert(input.end(), length.begin(), length.end());
  input.insert(input.end(), service.begin(), service.end());
}

Bytes service(wire::FoeOpCode op_code, std::uint32_t value, std::string_view text = {}) {
  Bytes bytes(wire::FoeHeader::kSize);
  wire::FoeHeader{op_code, value}.encode(std::span(bytes).first<wire::FoeHeader::kSize>());
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  talk_to_drive(input, wire::AlState::kBootstrap);
  talk_to_drive(input, wire::AlState::kPreOp);
  ecat_master::FileSettings settings;
  settings.largest = 4096;
  FileTransfer read({"file"}, settings);
  talk_to_master(input, read);
  if (read.result() && read.result()->size() > settings.largest) std::abort();
  FileTransfer write({"file"}, Bytes(200, std::byte{0x5A}));
  talk_to_master(input, write);
}

std::vector<Bytes> seeds() {
  using wire::FoeOpCode;
  Bytes firmware;
  append(firmware, service(FoeOpCode::kWriteRequest, 0, "a.efw"));
  auto packet = service(FoeOpCode::kData, 1);
  const auto image = slaves::msd::make_firmware(slaves::msd::Variant::kMsd, {124, 31, 0}, Bytes(20));
  packet.insert(packet.end(), image.begin(), image.end());
  for (int i = 0; i < 3; ++i) append(firmware, packet);
  Bytes parameters;
  append(parameters, service(FoeOpCode::kWriteRequest, 0, "parameters.txt"));
  append(parameters, service(FoeOpCode::kData, 1, "6065:00 = 4711\n1600:00 = 1\n2003:00 = \"x\"\n"));
  append(parameters, service(FoeOpCode::kReadRequest, 0, "parameters.txt"));
  append(parameters, service(FoeOpCode::kAck, 1));
  Bytes answers;
  append(answers, service(FoeOpCode::kBusy, 0x00640032, "wait"));
  append(answers, service(FoeOpCode::kAck, 0));
  append(answers, service(FoeOpCode::kData, 1, std::string(kRoom - wire::FoeHeader::kSize, 'x')));
  append(answers, service(FoeOpCode::kAck, 1));
  append(answers, service(FoeOpCode::kData, 2, "x"));
  append(answers, service(FoeOpCode::kError, 0x8001, "none"));
  return {firmware, parameters, answers};
}

}  // namespace driveline::fuzz
