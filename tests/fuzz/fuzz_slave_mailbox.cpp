// Malformed mailbox messages of all kinds for a drive in PREOP, and for a device from an ESI file: complete access,
// PDOs that can be mapped and assigned, two sync managers in each direction. Input: consecutive messages, each after
// its length in two bytes; answers are fetched in between.

#include <array>

#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/mailbox.hpp"
#include "fuzz_seeds.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

constexpr std::size_t kMailboxBytes = 512;

/// A CoE mailbox with this service behind the CoE header.
void append_coe(Bytes& input, wire::CoeService service, std::span<const std::uint8_t> data) {
  Bytes mailbox(wire::MailboxHeader::kSize + wire::CoeHeader::kSize);
  wire::MailboxHeader header;
  header.length = static_cast<std::uint16_t>(wire::CoeHeader::kSize + data.size());
  header.type = wire::MailboxType::kCoe;
  header.encode(std::span(mailbox).first<wire::MailboxHeader::kSize>());
  wire::CoeHeader{0, service}.encode(std::span(mailbox).subspan<wire::MailboxHeader::kSize, wire::CoeHeader::kSize>());
  for (const auto byte : data) mailbox.push_back(static_cast<std::byte>(byte));
  const auto length = bytes::to_le_bytes(static_cast<std::uint16_t>(mailbox.size()));
  input.insert(input.end(), length.begin(), length.end());
  input.insert(input.end(), mailbox.begin(), mailbox.end());
}

/// The mixed device of the examples.
std::shared_ptr<const slaves::generic::DeviceModel> mixed_device() {
  static const auto kModel = slaves::generic::DeviceModel::create(example_device("MX4")).value();
  return kModel;
}

void talk(slaves::Device& device, std::span<const std::byte> input) {
  static_cast<void>(device.transition(wire::AlState::kInit, wire::AlState::kPreOp));
  std::array<std::byte, kMailboxBytes> reply{};
  std::chrono::nanoseconds now{0};
  while (input.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(bytes::load_le<std::uint16_t>(input), input.size() - 2);
    std::array<std::byte, kMailboxBytes> mailbox{};
    std::copy_n(input.begin() + 2, std::min(length, mailbox.size()), mailbox.begin());
    input = input.subspan(2 + length);
    device.mailbox_request(mailbox);
    const auto bytes = device.mailbox_reply(reply);
    if (bytes > reply.size()) std::abort();
    if (bytes > 0 && !wire::MailboxHeader::decode(std::span(reply).first(bytes))) std::abort();
    now += device.process_data_period();
    device.advance(now);
  }
}

/// After any change of mapping and assignment, process data must still work.
void exchange(slaves::Device& device) {
  static_cast<void>(device.transition(wire::AlState::kPreOp, wire::AlState::kSafeOp));
  const auto& managers = device.profile().sync_managers;
  for (std::size_t n = 0; n < managers.size(); ++n) {
    std::vector<std::byte> data(device.process_data_size(n), std::byte{0xA5});
    if (managers[n].use == slaves::SyncManagerLayout::Use::kOutputs) device.write_outputs(n, data);
    if (managers[n].use == slaves::SyncManagerLayout::Use::kInputs) device.read_inputs(n, data);
  }
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  slaves::msd::MsdDrive drive;
  talk(drive, input);
  exchange(drive);
  slaves::generic::GenericDevice mixed(mixed_device(), {});
  talk(mixed, input);
  exchange(mixed);
}

std::vector<Bytes> seeds() {
  constexpr std::uint8_t kUploadIdentity[] = {0x40, 0x18, 0x10, 0x01, 0, 0, 0, 0};
  constexpr std::uint8_t kUploadName[] = {0x40, 0x03, 0x20, 0x00, 0, 0, 0, 0};
  constexpr std::uint8_t kUploadAll[] = {0x50, 0x18, 0x10, 0x00, 0, 0, 0, 0};
  constexpr std::uint8_t kUploadSegment[] = {0x60, 0, 0, 0, 0, 0, 0, 0};
  constexpr std::uint8_t kDownloadMapping[] = {0x23, 0x00, 0x16, 0x01, 0x10, 0x00, 0x40, 0x60};
  constexpr std::uint8_t kDownloadCount[] = {0x2F, 0x00, 0x16, 0x00, 0x01, 0, 0, 0};
  constexpr std::uint8_t kDownloadName[] = {0x21, 0x03, 0x20, 0x00, 100, 0, 0, 0, 'a', 'b', 'c'};
  constexpr std::uint8_t kDownloadSegment[] = {0x01, 'd', 'e', 'f', 'g', 'h', 'i', 'j'};
  constexpr std::uint8_t kAbort[] = {0x80, 0x18, 0x10, 0x01, 0, 0, 4, 5};
  constexpr std::uint8_t kObjectList[] = {0x01, 0, 0, 0, 0x01, 0x00};
  constexpr std::uint8_t kObjectDescription[] = {0x03, 0, 0, 0, 0x18, 0x10};
  constexpr std::uint8_t kEntryDescription[] = {0x05, 0, 0, 0, 0x18, 0x10, 0x01, 0xFF};
  Bytes transfers;
  for (const auto& sdo : {std::span<const std::uint8_t>(kUploadIdentity), std::span<const std::uint8_t>(kUploadName),
                          std::span<const std::uint8_t>(kUploadSegment), std::span<const std::uint8_t>(kUploadAll),
                          std::span<const std::uint8_t>(kDownloadMapping),
                          std::span<const std::uint8_t>(kDownloadCount), std::span<const std::uint8_t>(kDownloadName),
                          std::span<const std::uint8_t>(kDownloadSegment), std::span<const std::uint8_t>(kAbort)}) {
    append_coe(transfers, wire::CoeService::kSdoRequest, sdo);
  }
  Bytes information;
  append_coe(information, wire::CoeService::kSdoInformation, kObjectList);
  append_coe(information, wire::CoeService::kSdoInformation, kObjectDescription);
  append_coe(information, wire::CoeService::kSdoInformation, kEntryDescription);
  constexpr std::uint8_t kUploadRecord[] = {0x50, 0x00, 0x80, 0x00, 0, 0, 0, 0};
  constexpr std::uint8_t kUploadTexts[] = {0x50, 0x10, 0x80, 0x01, 0, 0, 0, 0};
  constexpr std::uint8_t kDownloadRecord[] = {0x31, 0x00, 0x80, 0x00, 14, 0, 0, 0, 4, 0, 3,
                                              0,    50,   0,    1,    2,  3, 4, 5, 6, 7, 8};
  constexpr std::uint8_t kAssign[] = {0x31, 0x12, 0x1C, 0x00, 6, 0, 0, 0, 2, 0, 0x10, 0x16, 0x00, 0x16};
  constexpr std::uint8_t kMap[] = {0x31, 0x00, 0x16, 0x00, 14, 0, 0,    0,    3,    0,    0x01,
                                   0x01, 0x00, 0x70, 0x05, 0,  0, 0x00, 0x18, 0x04, 0x00, 0x70};
  Bytes whole;
  for (const auto& sdo : {std::span<const std::uint8_t>(kUploadRecord), std::span<const std::uint8_t>(kUploadTexts),
                          std::span<const std::uint8_t>(kUploadSegment), std::span<const std::uint8_t>(kDownloadRecord),
                          std::span<const std::uint8_t>(kAssign), std::span<const std::uint8_t>(kMap)}) {
    append_coe(whole, wire::CoeService::kSdoRequest, sdo);
  }
  std::vector<Bytes> inputs = {transfers, information, whole};
  for (auto& recorded : recorded_mailboxes()) inputs.push_back(std::move(recorded));
  return inputs;
}

}  // namespace driveline::fuzz
