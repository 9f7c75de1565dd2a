#include "driveline/ecat_master/coe/sdo_transfer.hpp"

#include <algorithm>

#include "coe/about_object.hpp"

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

std::array<std::byte, SdoHeader::kSize> initiate(std::uint8_t command, const SdoAddress& at, std::uint32_t data) {
  std::array<std::byte, SdoHeader::kSize> sdo{};
  SdoHeader{command, at.index, at.subindex, bytes::to_le_bytes(data)}.encode(sdo);
  return sdo;
}

}  // namespace

SdoTransfer::SdoTransfer(SdoAddress at, std::uint8_t priority)
    : MailboxDialogue(wire::MailboxType::kCoe, priority), at_(at), download_(false) {}

SdoTransfer::SdoTransfer(SdoAddress at, std::vector<std::byte> data, std::uint8_t priority)
    : MailboxDialogue(wire::MailboxType::kCoe, priority), at_(at), download_(true), data_(std::move(data)) {}

facts::ObjectAddress SdoTransfer::object() const noexcept {
  return {at_.index, at_.subindex};
}

Error SdoTransfer::size_error(std::size_t expected, std::size_t received) const noexcept {
  return {facts::SdoSize{.object = object(),
                         .expected = static_cast<std::uint32_t>(expected),
                         .received = static_cast<std::uint32_t>(received)},
          position_};
}

void SdoTransfer::load(std::span<const std::byte> sdo) {
  outgoing_.resize(CoeHeader::kSize + sdo.size());
  CoeHeader{0, CoeService::kSdoRequest}.encode(std::span(outgoing_).first<CoeHeader::kSize>());
  std::copy(sdo.begin(), sdo.end(), outgoing_.begin() + CoeHeader::kSize);
}

void SdoTransfer::begin(std::uint16_t position, MailboxRoom room) {
  position_ = position;
  max_sdo_ = room.out < CoeHeader::kSize ? 0 : room.out - CoeHeader::kSize;
  const std::uint8_t access = at_.complete ? SdoHeader::kCompleteAccess : std::uint8_t{0};
  if (!download_) {
    load(initiate(static_cast<std::uint8_t>((code_of(SdoRequestCommand::kInitiateUpload) << 5) | access), at_, 0));
    return;
  }
  // Complete access is never expedited: some slaves accept no other form.
  if (!data_.empty() && data_.size() <= 4 && !at_.complete) {
    auto sdo = initiate(wire::expedited_command(code_of(SdoRequestCommand::kInitiateDownload), data_.size()), at_, 0);
    std::copy(data_.begin(), data_.end(), sdo.begin() + 4);
    load(sdo);
    done_bytes_ = data_.size();
    return;
  }
  const auto command = static_cast<std::uint8_t>((code_of(SdoRequestCommand::kInitiateDownload) << 5) |
                                                 SdoHeader::kSizeIndicated | access);
  load(initiate(command, at_, static_cast<std::uint32_t>(data_.size())));
  const auto first = max_sdo_ < SdoHeader::kSize ? 0 : max_sdo_ - SdoHeader::kSize;
  done_bytes_ = std::min(data_.size(), first);
  outgoing_.insert(outgoing_.end(), data_.begin(), data_.begin() + static_cast<std::ptrdiff_t>(done_bytes_));
}

/// Records that an unusable message arrived.
MailboxDialogue::Reaction SdoTransfer::stray() {
  stray_ = true;
  return Reaction::kForeign;
}

MailboxDialogue::Reaction SdoTransfer::receive(std::span<const std::byte> service) {
  const auto coe = CoeHeader::decode(service);
  if (!coe || service.size() <= CoeHeader::kSize) return Reaction::kForeign;
  const auto sdo = service.subspan(CoeHeader::kSize);
  const auto specifier = std::to_integer<std::uint8_t>(sdo[0]) >> 5;
  const bool abort = specifier == code_of(SdoResponseCommand::kAbort);
  // Some slaves send their abort as a request; both forms are answers.
  if (coe->service != CoeService::kSdoResponse && !(abort && coe->service == CoeService::kSdoRequest))
    return Reaction::kForeign;
  if (abort) {
    const auto header = SdoHeader::decode(sdo);
    if (!header || header->index != at_.index || header->subindex != at_.subindex) return stray();
    const auto code = static_cast<wire::SdoAbort>(header->data_u32());
    result_ = tl::unexpected(Error{facts::SdoAbort{object(), code}, position_});
    return Reaction::kDone;
  }
  return phase_ == Phase::kInitiate ? receive_initiated(sdo) : receive_segment(sdo);
}

MailboxDialogue::Reaction SdoTransfer::receive_initiated(std::span<const std::byte> sdo) {
  const auto header = SdoHeader::decode(sdo);
  const auto expected =
      code_of(download_ ? SdoResponseCommand::kInitiateDownload : SdoResponseCommand::kInitiateUpload);
  if (!header || header->specifier() != expected || header->index != at_.index || header->subindex != at_.subindex) {
    return stray();
  }
  if (!download_) return receive_uploaded(*header, sdo.subspan(SdoHeader::kSize));
  if (done_bytes_ == data_.size()) {
    result_ = std::vector<std::byte>{};
    return Reaction::kDone;
  }
  phase_ = Phase::kSegments;
  request_segment();
  return Reaction::kSend;
}

MailboxDialogue::Reaction SdoTransfer::receive_uploaded(const wire::SdoHeader& header,
                                                        std::span<const std::byte> rest) {
  if (header.expedited()) {
    result_ = std::vector<std::byte>(header.data.begin(),
                                     header.data.begin() + static_cast<std::ptrdiff_t>(header.expedited_size()));
    return Reaction::kDone;
  }
  complete_size_ = header.data_u32();
  if (complete_size_ > kMaxObjectBytes) {
    return give_up(size_error(kMaxObjectBytes, complete_size_), wire::SdoAbort::kOutOfMemory);
  }
  // Bytes behind the complete size are padding of the mailbox.
  const auto first = rest.first(std::min(rest.size(), complete_size_));
  data_.assign(first.begin(), first.end());
  if (data_.size() == complete_size_) {
    result_ = std::move(data_);
    return Reaction::kDone;
  }
  phase_ = Phase::kSegments;
  request_segment();
  return Reaction::kSend;
}

/// Requests the next segment of an upload, or sends the next segment of a download.
void SdoTransfer::request_segment() {
  if (!download_) {
    std::array<std::byte, SdoHeader::kSize> sdo{};
    sdo[0] = static_cast<std::byte>((code_of(SdoRequestCommand::kUploadSegment) << 5) | (toggle_ ? 0x10 : 0));
    load(sdo);
    return;
  }
  const auto room = max_sdo_ < SdoSegmentHeader::kSize ? 0 : max_sdo_ - SdoSegmentHeader::kSize;
  const auto left = data_.size() - done_bytes_;
  segment_bytes_ = std::min(left, room);
  const auto unused =
      segment_bytes_ < SdoSegmentHeader::kMinData ? SdoSegmentHeader::kMinData - segment_bytes_ : std::size_t{0};
  std::vector<std::byte> sdo(SdoSegmentHeader::kSize + std::max(segment_bytes_, SdoSegmentHeader::kMinData));
  sdo[0] = static_cast<std::byte>(SdoSegmentHeader{code_of(SdoRequestCommand::kDownloadSegment), toggle_,
                                                   static_cast<std::uint8_t>(unused), segment_bytes_ == left}
                                      .raw());
  std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(done_bytes_), segment_bytes_,
              sdo.begin() + SdoSegmentHeader::kSize);
  load(sdo);
}

MailboxDialogue::Reaction SdoTransfer::receive_segment(std::span<const std::byte> sdo) {
  const auto segment = SdoSegmentHeader::from_raw(std::to_integer<std::uint8_t>(sdo[0]));
  const auto expected = code_of(download_ ? SdoResponseCommand::kDownloadSegment : SdoResponseCommand::kUploadSegment);
  if (segment.specifier != expected) return stray();
  if (segment.toggle != toggle_) {
    return give_up({facts::MailboxMalformed{object()}, position_}, wire::SdoAbort::kToggleNotAlternated);
  }
  toggle_ = !toggle_;
  if (!download_) return receive_uploaded_segment(segment, sdo.subspan(SdoSegmentHeader::kSize));
  done_bytes_ += segment_bytes_;
  if (done_bytes_ == data_.size()) {
    result_ = std::vector<std::byte>{};
    return Reaction::kDone;
  }
  request_segment();
  return Reaction::kSend;
}

MailboxDialogue::Reaction SdoTransfer::receive_uploaded_segment(const wire::SdoSegmentHeader& segment,
                                                                std::span<const std::byte> data) {
  std::size_t bytes = data.size();
  if (bytes <= SdoSegmentHeader::kMinData) bytes -= std::min<std::size_t>(bytes, segment.unused);
  if (data_.size() + bytes > complete_size_ || (bytes == 0 && !segment.last)) {
    return give_up(size_error(complete_size_, data_.size() + bytes), wire::SdoAbort::kLengthMismatch);
  }
  data_.insert(data_.end(), data.begin(), data.begin() + static_cast<std::ptrdiff_t>(bytes));
  if (!segment.last) {
    request_segment();
    return Reaction::kSend;
  }
  if (data_.size() != complete_size_) {
    result_ = tl::unexpected(size_error(complete_size_, data_.size()));
  } else {
    result_ = std::move(data_);
  }
  return Reaction::kDone;
}

void SdoTransfer::load_abort(wire::SdoAbort code) {
  load(initiate(static_cast<std::uint8_t>(code_of(SdoRequestCommand::kAbort) << 5), at_,
                static_cast<std::uint32_t>(code)));
  phase_ = Phase::kAborting;
}

/// Ends the transfer with an error; a lost abort only leaves the slave waiting.
MailboxDialogue::Reaction SdoTransfer::give_up(const Error& error, wire::SdoAbort code) {
  result_ = tl::unexpected(error);
  load_abort(code);
  return Reaction::kSend;
}

bool SdoTransfer::takes_leave() {
  load_abort(wire::SdoAbort::kTimeout);
  return true;
}

void SdoTransfer::fail(const Error& failure) {
  // Keep the first error: an abort that cannot be delivered adds no information.
  if (phase_ == Phase::kAborting) return;
  auto error = about_object(failure, object());
  if (stray_ && error.is<facts::MailboxTimeout>()) error.facts = facts::MailboxMalformed{object()};
  result_ = tl::unexpected(error);
}

void SdoTransfer::completed() {
  if (callback_) callback_(result_);
}

}  // namespace driveline::ecat_master
