// Servo profile over EtherCAT, both ends. Input: consecutive SoE services, each after its length in two bytes. They go
// to a drive, and to a master that reads, writes or listens.

#include <algorithm>
#include <array>

#include "driveline/ecat_master/soe/soe_log.hpp"
#include "driveline/ecat_master/soe/soe_transfer.hpp"
#include "driveline/slaves/generic/soe_drives.hpp"
#include "driveline/slaves/mailbox/soe_server.hpp"
#include "driveline/wire/soe.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

using ecat_master::MailboxDialogue;
using ecat_master::SoeTransfer;
using wire::SoeElement;
using wire::SoeHeader;
using wire::SoeOpCode;

constexpr std::size_t kRoom = 32;

template <typename Take>
void for_each_service(std::span<const std::byte> input, Take&& take) {
  while (input.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(bytes::load_le<std::uint16_t>(input), input.size() - 2);
    take(input.subspan(2, std::min(length, kRoom)));
    input = input.subspan(2 + length);
  }
}

void talk_to_drive(std::span<const std::byte> input) {
  slaves::generic::SoeDrives drive(2, slaves::generic::SoeDrives::ProcessData::kByLists);
  slaves::SoeServer server(drive);
  std::chrono::nanoseconds now{0};
  std::array<std::byte, kRoom> answer{};
  for_each_service(input, [&](std::span<const std::byte> service) {
    const auto length = server.request({service, kRoom, wire::AlState::kPreOp}, answer);
    if (length && *length > answer.size()) std::abort();
    // An answer must end.
    std::size_t mails = 0;
    while (server.unsolicited(answer) != 0) {
      if (++mails > 100) std::abort();
    }
    now += std::chrono::milliseconds{1};
    drive.advance(now);
  });
  // Whatever the lists contain can be exchanged: at most a word and two long values of each drive.
  std::array<std::byte, 20> process_data{};
  if (drive.outputs_size() > process_data.size() || drive.inputs_size() > process_data.size()) std::abort();
  drive.write_outputs(std::span(process_data).first(drive.outputs_size()));
  drive.read_inputs(process_data);
  // Any accepted value is within its limits.
  const auto gain = drive.values(0).raw(*drive.values(0).table().find({100}));
  if (gain < 1 || gain > 10000) std::abort();
}

void talk_to_master(std::span<const std::byte> input, SoeTransfer& transfer) {
  bool open = true;
  transfer.begin(0, {kRoom, kRoom});
  if (transfer.outgoing().size() > kRoom) std::abort();
  for_each_service(input, [&](std::span<const std::byte> service) {
    if (open) open = transfer.receive(service) != MailboxDialogue::Reaction::kDone;
  });
  if (open) transfer.fail({ecat_master::facts::MailboxTimeout{}, 0});
  if (open && transfer.result()) std::abort();
  if (!transfer.result()) return;
  const auto& reading = *transfer.result();
  static_cast<void>(ecat_master::decode_parameter(reading));
  static_cast<void>(ecat_master::decode_parameter(reading, wire::SoeAttribute{.list = true}));
  static_cast<void>(ecat_master::idns_of(reading.data));
}

void append(Bytes& input, const SoeHeader& header, std::initializer_list<unsigned> data = {}) {
  Bytes service(SoeHeader::kSize);
  header.encode(std::span(service).first<SoeHeader::kSize>());
  for (const auto value : data) service.push_back(static_cast<std::byte>(value));
  const auto length = bytes::to_le_bytes(static_cast<std::uint16_t>(service.size()));
  input.insert(input.end(), length.begin(), length.end());
  input.insert(input.end(), service.begin(), service.end());
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  talk_to_drive(input);
  SoeTransfer read({0, {17}}, SoeElement::kName | SoeElement::kAttribute | SoeElement::kValue);
  talk_to_master(input, read);
  SoeTransfer write({0, {17}}, SoeElement::kValue, Bytes(20, std::byte{0x5A}));
  talk_to_master(input, write);
  SoeTransfer longer({0, {17}}, SoeElement::kValue, Bytes(200, std::byte{0x5A}));
  for (const auto& service : longer.split(0, kRoom)) {
    if (service.size() > kRoom) std::abort();
  }
  talk_to_master(input, longer);
  ecat_master::SoeLog log;
  for_each_service(input, [&](std::span<const std::byte> service) { log.receive({0, 0x1001}, service, {}); });
  for (const auto& record : log.take()) static_cast<void>(describe(record));
}

std::vector<Bytes> seeds() {
  const auto all = wire::SoeElementSet::of(0x46);
  Bytes requests;
  append(requests, {SoeOpCode::kReadRequest, false, false, 0, SoeElement::kValue, 17});
  append(requests, {SoeOpCode::kReadRequest, false, false, 0, all, 100});
  append(requests, {SoeOpCode::kWriteRequest, false, false, 0, SoeElement::kValue, 100}, {1, 2});
  append(requests, {SoeOpCode::kWriteRequest, false, false, 0, SoeElement::kValue, 99}, {3, 0});
  append(requests, {SoeOpCode::kReadRequest, false, false, 0, SoeElement::kState, 99});
  append(requests, {SoeOpCode::kWriteRequest, false, false, 1, SoeElement::kValue, 16}, {4, 0, 4, 0, 40, 0, 51, 0});
  append(requests, {SoeOpCode::kWriteRequest, true, false, 0, SoeElement::kValue, 1}, {1});
  append(requests, {SoeOpCode::kWriteRequest, false, false, 0, SoeElement::kValue, 100}, {2});
  Bytes answers;
  append(answers, {SoeOpCode::kNotification, false, false, 0, SoeElement::kState, 99}, {3, 0});
  append(answers, {SoeOpCode::kEmergency, false, false, 0, {}, 0}, {0x30, 0x81, 0, 0, 0, 0, 0, 0});
  append(answers, {SoeOpCode::kReadResponse, true, false, 0, all, 1}, {1, 0, 1, 0, 'N', 1, 0, 0x55});
  append(answers, {SoeOpCode::kReadResponse, false, false, 0, all, 17}, {0, 2, 0, 2, 0, 1, 0});
  append(answers, {SoeOpCode::kWriteResponse, false, true, 0, SoeElement::kValue, 17}, {8, 0x70});
  return {requests, answers};
}

}  // namespace driveline::fuzz
