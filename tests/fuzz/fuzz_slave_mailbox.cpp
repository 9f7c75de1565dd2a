// Mailboxes of every kind of malformation into a drive in PREOP. Input: mailboxes one after the other, each with its
// length in two bytes in front; answers are fetched in between.

#include <array>

#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/mailbox.hpp"
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
  const auto length = wire::to_le_bytes(static_cast<std::uint16_t>(mailbox.size()));
  input.insert(input.end(), length.begin(), length.end());
  input.insert(input.end(), mailbox.begin(), mailbox.end());
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  slaves::msd::MsdDrive drive;
  static_cast<void>(drive.transition(wire::AlState::kInit, wire::AlState::kPreOp));
  std::array<std::byte, kMailboxBytes> reply{};
  std::chrono::nanoseconds now{0};
  while (input.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(wire::load_le<std::uint16_t>(input), input.size() - 2);
    std::array<std::byte, kMailboxBytes> mailbox{};
    std::copy_n(input.begin() + 2, std::min(length, mailbox.size()), mailbox.begin());
    input = input.subspan(2 + length);
    drive.mailbox_request(mailbox);
    const auto bytes = drive.mailbox_reply(reply);
    if (bytes > reply.size()) std::abort();
    if (bytes > 0 && !wire::MailboxHeader::decode(std::span(reply).first(bytes))) std::abort();
    now += drive.process_data_period();
    drive.advance(now);
  }
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
  return {transfers, information};
}

}  // namespace driveline::fuzz
