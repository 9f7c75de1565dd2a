#include "driveline/ecat_master/coe_client.hpp"

#include <algorithm>

namespace driveline::ecat_master {
namespace {

using wire::CoeHeader;
using wire::CoeService;
using wire::SdoHeader;
using wire::SdoRequestCommand;
using wire::SdoResponseCommand;
using wire::SdoSegmentHeader;

constexpr std::uint8_t code_of(SdoRequestCommand command) {
  return static_cast<std::uint8_t>(command);
}
constexpr std::uint8_t code_of(SdoResponseCommand command) {
  return static_cast<std::uint8_t>(command);
}

/// A service of the mailbox: CoE header in front of `sdo`.
std::vector<std::byte> with_coe_header(std::span<const std::byte> sdo) {
  std::vector<std::byte> service(CoeHeader::kSize + sdo.size());
  CoeHeader{0, CoeService::kSdoRequest}.encode(std::span(service).first<CoeHeader::kSize>());
  std::copy(sdo.begin(), sdo.end(), service.begin() + CoeHeader::kSize);
  return service;
}

std::vector<std::byte> initiate(std::uint8_t command, std::uint16_t index, std::uint8_t subindex, std::uint32_t data) {
  std::vector<std::byte> sdo(SdoHeader::kSize);
  SdoHeader{command, index, subindex, wire::to_le_bytes(data)}.encode(std::span(sdo).first<SdoHeader::kSize>());
  return sdo;
}

bool is_sdo_answer(std::span<const std::byte> service) {
  const auto coe = CoeHeader::decode(service);
  if (!coe || service.size() <= CoeHeader::kSize) return false;
  const auto specifier = std::to_integer<std::uint8_t>(service[CoeHeader::kSize]) >> 5;
  // Some slaves send their abort as a request; both are answers.
  return coe->service == CoeService::kSdoResponse ||
         (coe->service == CoeService::kSdoRequest && specifier == code_of(SdoResponseCommand::kAbort));
}

}  // namespace

Error CoeClient::size_error(std::uint16_t index, std::uint8_t subindex, std::size_t expected,
                            std::size_t received) const noexcept {
  Error error;
  error.kind = ErrorKind::kSdoSize;
  error.slave = mailbox_.slave().position;
  error.address = index;
  error.subindex = subindex;
  error.expected = static_cast<std::uint32_t>(expected);
  error.received = static_cast<std::uint32_t>(received);
  return error;
}

Error CoeClient::malformed(Address at) const noexcept {
  Error error;
  error.kind = ErrorKind::kMailboxMalformed;
  error.slave = mailbox_.slave().position;
  error.address = at.index;
  error.subindex = at.subindex;
  return error;
}

/// One SDO request and its answer, both without CoE header; an abort becomes an error.
Result<std::vector<std::byte>> CoeClient::transact(Address at, std::span<const std::byte> sdo) {
  auto service = mailbox_.transact(wire::MailboxType::kCoe, with_coe_header(sdo), is_sdo_answer);
  if (!service) {
    Error error = service.error();
    // Errors of the bus name the register that was not reached.
    if (error.kind == ErrorKind::kMailboxTimeout || error.kind == ErrorKind::kMailboxError ||
        error.kind == ErrorKind::kMailboxMalformed) {
      error.address = at.index;
      error.subindex = at.subindex;
    }
    return tl::unexpected(error);
  }
  service->erase(service->begin(), service->begin() + CoeHeader::kSize);
  if ((std::to_integer<std::uint8_t>((*service)[0]) >> 5) == code_of(SdoResponseCommand::kAbort)) {
    const auto header = SdoHeader::decode(*service);
    if (!header) return tl::unexpected(malformed(at));
    Error error = malformed(at);
    error.kind = ErrorKind::kSdoAbort;
    error.code = header->data_u32();
    return tl::unexpected(error);
  }
  return service;
}

void CoeClient::abort(Address at, wire::SdoAbort code) {
  const auto sdo = initiate(static_cast<std::uint8_t>(code_of(SdoRequestCommand::kAbort) << 5), at.index, at.subindex,
                            static_cast<std::uint32_t>(code));
  // The transfer has failed already and its error is on the way up; a lost abort only leaves the slave waiting.
  static_cast<void>(mailbox_.send(wire::MailboxType::kCoe, with_coe_header(sdo)).has_value());
}

Result<std::vector<std::byte>> CoeClient::upload(std::uint16_t index, std::uint8_t subindex, bool complete) {
  const Address at{index, subindex};
  const auto command = static_cast<std::uint8_t>((code_of(SdoRequestCommand::kInitiateUpload) << 5) |
                                                 (complete ? SdoHeader::kCompleteAccess : 0));
  auto answer = transact(at, initiate(command, index, subindex, 0));
  if (!answer) return answer;
  const auto header = SdoHeader::decode(*answer);
  if (!header || header->specifier() != code_of(SdoResponseCommand::kInitiateUpload) || header->index != index ||
      header->subindex != subindex) {
    return tl::unexpected(malformed(at));
  }
  if (header->expedited()) {
    return std::vector<std::byte>(header->data.begin(),
                                  header->data.begin() + static_cast<std::ptrdiff_t>(header->expedited_size()));
  }
  const std::size_t complete_size = header->data_u32();
  if (complete_size > kMaxObjectBytes) {
    abort(at, wire::SdoAbort::kOutOfMemory);
    return tl::unexpected(size_error(index, subindex, kMaxObjectBytes, complete_size));
  }
  std::vector<std::byte> data(answer->begin() + SdoHeader::kSize, answer->end());
  // Bytes behind the complete size are padding of the mailbox.
  if (data.size() > complete_size) data.resize(complete_size);
  if (data.size() < complete_size) {
    if (auto done = upload_segments(at, data, complete_size); !done) return tl::unexpected(done.error());
  }
  return data;
}

Result<void> CoeClient::upload_segments(Address at, std::vector<std::byte>& data, std::size_t complete_size) {
  bool toggle = false;
  for (;;) {
    std::array<std::byte, SdoHeader::kSize> request{};
    request[0] = static_cast<std::byte>((code_of(SdoRequestCommand::kUploadSegment) << 5) | (toggle ? 0x10 : 0));
    auto answer = transact(at, request);
    if (!answer) return tl::unexpected(answer.error());
    const auto segment = SdoSegmentHeader::from_raw(std::to_integer<std::uint8_t>((*answer)[0]));
    if (segment.specifier != code_of(SdoResponseCommand::kUploadSegment) || segment.toggle != toggle) {
      abort(at, wire::SdoAbort::kToggleNotAlternated);
      return tl::unexpected(malformed(at));
    }
    std::size_t bytes = answer->size() - SdoSegmentHeader::kSize;
    if (bytes <= SdoSegmentHeader::kMinData) bytes -= std::min<std::size_t>(bytes, segment.unused);
    if (data.size() + bytes > complete_size || (bytes == 0 && !segment.last)) {
      abort(at, wire::SdoAbort::kLengthMismatch);
      return tl::unexpected(size_error(at.index, at.subindex, complete_size, data.size() + bytes));
    }
    const auto begin = answer->begin() + SdoSegmentHeader::kSize;
    data.insert(data.end(), begin, begin + static_cast<std::ptrdiff_t>(bytes));
    if (segment.last) break;
    toggle = !toggle;
  }
  if (data.size() != complete_size)
    return tl::unexpected(size_error(at.index, at.subindex, complete_size, data.size()));
  return {};
}

Result<void> CoeClient::download(std::uint16_t index, std::uint8_t subindex, std::span<const std::byte> data,
                                 bool complete) {
  const Address at{index, subindex};
  const std::uint8_t access = complete ? SdoHeader::kCompleteAccess : std::uint8_t{0};
  std::vector<std::byte> sdo;
  std::size_t sent = data.size();
  if (!data.empty() && data.size() <= 4 && !complete) {
    sdo = initiate(wire::expedited_command(code_of(SdoRequestCommand::kInitiateDownload), data.size()), index, subindex,
                   0);
    std::copy(data.begin(), data.end(), sdo.begin() + 4);
  } else {
    const auto command = static_cast<std::uint8_t>((code_of(SdoRequestCommand::kInitiateDownload) << 5) |
                                                   SdoHeader::kSizeIndicated | access);
    sdo = initiate(command, index, subindex, static_cast<std::uint32_t>(data.size()));
    sent = std::min(data.size(), mailbox_.max_service() - CoeHeader::kSize - SdoHeader::kSize);
    sdo.insert(sdo.end(), data.begin(), data.begin() + static_cast<std::ptrdiff_t>(sent));
  }
  auto answer = transact(at, sdo);
  if (!answer) return tl::unexpected(answer.error());
  const auto header = SdoHeader::decode(*answer);
  if (!header || header->specifier() != code_of(SdoResponseCommand::kInitiateDownload) || header->index != index ||
      header->subindex != subindex) {
    return tl::unexpected(malformed(at));
  }
  return sent == data.size() ? Result<void>{} : download_segments(at, data.subspan(sent));
}

Result<void> CoeClient::download_segments(Address at, std::span<const std::byte> rest) {
  bool toggle = false;
  while (!rest.empty()) {
    const std::size_t bytes =
        std::min(rest.size(), mailbox_.max_service() - CoeHeader::kSize - SdoSegmentHeader::kSize);
    const auto unused = bytes < SdoSegmentHeader::kMinData ? SdoSegmentHeader::kMinData - bytes : 0;
    std::vector<std::byte> sdo(SdoSegmentHeader::kSize + std::max(bytes, SdoSegmentHeader::kMinData));
    sdo[0] = static_cast<std::byte>(SdoSegmentHeader{code_of(SdoRequestCommand::kDownloadSegment), toggle,
                                                     static_cast<std::uint8_t>(unused), bytes == rest.size()}
                                        .raw());
    std::copy_n(rest.begin(), bytes, sdo.begin() + SdoSegmentHeader::kSize);
    auto answer = transact(at, sdo);
    if (!answer) return tl::unexpected(answer.error());
    const auto segment = SdoSegmentHeader::from_raw(std::to_integer<std::uint8_t>((*answer)[0]));
    if (segment.specifier != code_of(SdoResponseCommand::kDownloadSegment) || segment.toggle != toggle) {
      abort(at, wire::SdoAbort::kToggleNotAlternated);
      return tl::unexpected(malformed(at));
    }
    rest = rest.subspan(bytes);
    toggle = !toggle;
  }
  return {};
}

}  // namespace driveline::ecat_master
