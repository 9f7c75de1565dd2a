#include "driveline/slaves/coe/sdo_server.hpp"

#include <algorithm>

#include "driveline/slaves/coe/complete_access.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;
using wire::SdoHeader;
using wire::SdoRequestCommand;
using wire::SdoResponseCommand;
using wire::SdoSegmentHeader;

constexpr std::uint8_t command_byte(SdoResponseCommand command, std::uint8_t flags = 0) noexcept {
  return static_cast<std::uint8_t>((static_cast<unsigned>(command) << 5) | flags);
}

std::size_t put_header(const SdoHeader& header, std::span<std::byte> out) noexcept {
  header.encode(out.first<SdoHeader::kSize>());
  return SdoHeader::kSize;
}

/// Returns the size in bytes of the longest possible transfer.
std::size_t longest_transfer(const DictionaryTable& table, bool complete_access) noexcept {
  std::size_t longest = sizeof(std::uint64_t);
  for (const auto& row : table.rows()) longest = std::max(longest, byte_size(row));
  if (!complete_access) return longest;
  for (auto rows = table.next_object(0); !rows.empty(); rows = table.next_object(rows.front().index)) {
    longest = std::max(longest, complete_size(rows, 0));
  }
  return longest;
}

}  // namespace

SdoServer::SdoServer(ObjectDictionary& dictionary, DictionaryOwner& owner, const Options& options)
    : dictionary_(&dictionary),
      owner_(&owner),
      complete_access_(options.complete_access),
      fill_sign_(options.fill_sign),
      buffer_(longest_transfer(dictionary.table(), options.complete_access)) {}

SdoResult<std::size_t> SdoServer::read(const SdoAddress& address, AccessPhase phase) {
  if (!address.complete) return dictionary_->upload(address.index, address.subindex, phase, buffer_);
  if (!complete_access_) return tl::unexpected(SdoAbort::kNoCompleteAccess);
  return upload_complete(*dictionary_, address.index, address.subindex, phase, buffer_);
}

SdoResult<std::size_t> SdoServer::capacity(const SdoAddress& address, AccessPhase phase) const {
  if (!address.complete) {
    return dictionary_->writable(address.index, address.subindex, phase, *owner_).map([](const EntryRow* row) {
      return byte_size(*row);
    });
  }
  if (!complete_access_) return tl::unexpected(SdoAbort::kNoCompleteAccess);
  return writable_complete(*dictionary_, address.index, address.subindex, phase);
}

SdoResult<void> SdoServer::store(const SdoAddress& address, AccessPhase phase, std::span<const std::byte> data,
                                 bool size_known) {
  if (!address.complete) {
    return dictionary_->download(address.index, address.subindex, phase, data, *owner_, size_known);
  }
  if (!complete_access_) return tl::unexpected(SdoAbort::kNoCompleteAccess);
  return download_complete(*dictionary_, address.index, address.subindex, phase, data, *owner_);
}

std::size_t SdoServer::handle(std::span<const std::byte> request, AccessPhase phase, std::span<std::byte> out) {
  const auto header = SdoHeader::decode(request);
  if (!header) return abort(0, 0, SdoAbort::kInvalidCommand, out);
  const auto segment = SdoSegmentHeader::from_raw(header->command);
  switch (static_cast<SdoRequestCommand>(header->specifier())) {
    case SdoRequestCommand::kInitiateUpload:
      return initiate_upload(*header, phase, out);
    case SdoRequestCommand::kUploadSegment:
      return upload_segment(segment, out);
    case SdoRequestCommand::kInitiateDownload:
      return initiate_download(*header, request.subspan(SdoHeader::kSize), phase, out);
    case SdoRequestCommand::kDownloadSegment:
      return download_segment(segment, request.subspan(SdoSegmentHeader::kSize), phase, out);
    case SdoRequestCommand::kAbort:
      cancel();
      return 0;
  }
  return abort(header->index, header->subindex, SdoAbort::kInvalidCommand, out);
}

std::size_t SdoServer::abort(std::uint16_t index, std::uint8_t subindex, SdoAbort code, std::span<std::byte> out) {
  cancel();
  return put_header(
      {command_byte(SdoResponseCommand::kAbort), index, subindex, bytes::to_le_bytes(static_cast<std::uint32_t>(code))},
      out);
}

std::size_t SdoServer::abort_transfer(SdoAbort code, std::span<std::byte> out) {
  return abort(transfer_.address.index, transfer_.address.subindex, code, out);
}

std::byte SdoServer::filler(const SdoAddress& address, std::size_t size) const noexcept {
  if (!fill_sign_ || address.complete) return std::byte{0};
  const auto* row = dictionary_->table().find(address.index, address.subindex);
  const bool negative = (buffer_[size - 1] & std::byte{0x80}) != std::byte{0};
  return row != nullptr && is_signed(row->type) && negative ? std::byte{0xFF} : std::byte{0};
}

std::size_t SdoServer::initiate_upload(const SdoHeader& request, AccessPhase phase, std::span<std::byte> out) {
  cancel();
  const SdoAddress address{request.index, request.subindex, request.complete_access()};
  const auto size = read(address, phase);
  if (!size) return abort(request.index, request.subindex, size.error(), out);

  const auto flags = address.complete ? SdoHeader::kCompleteAccess : std::uint8_t{0};
  SdoHeader response{0, request.index, request.subindex, {}};
  if (*size > 0 && *size <= response.data.size()) {
    response.command = static_cast<std::uint8_t>(
        wire::expedited_command(static_cast<std::uint8_t>(SdoResponseCommand::kInitiateUpload), *size) | flags);
    response.data.fill(filler(address, *size));
    std::copy_n(buffer_.begin(), *size, response.data.begin());
    return put_header(response, out);
  }
  response.command =
      command_byte(SdoResponseCommand::kInitiateUpload, static_cast<std::uint8_t>(SdoHeader::kSizeIndicated | flags));
  response.data = bytes::to_le_bytes(static_cast<std::uint32_t>(*size));
  const std::size_t first = std::min(*size, out.size() - SdoHeader::kSize);
  std::copy_n(buffer_.begin(), first, out.begin() + SdoHeader::kSize);
  if (first < *size) transfer_ = {Transfer::Kind::kUpload, address, false, *size, first};
  return put_header(response, out) + first;
}

std::size_t SdoServer::upload_segment(SdoSegmentHeader request, std::span<std::byte> out) {
  if (transfer_.kind != Transfer::Kind::kUpload) return abort_transfer(SdoAbort::kInvalidCommand, out);
  if (request.toggle != transfer_.toggle) return abort_transfer(SdoAbort::kToggleNotAlternated, out);
  const std::size_t left = transfer_.size - transfer_.position;
  const std::size_t count = std::min(left, out.size() - SdoSegmentHeader::kSize);
  const std::size_t length = std::max(count, SdoSegmentHeader::kMinData);
  SdoSegmentHeader response{static_cast<std::uint8_t>(SdoResponseCommand::kUploadSegment), request.toggle,
                            static_cast<std::uint8_t>(length - count), count == left};
  out[0] = static_cast<std::byte>(response.raw());
  const auto data = out.subspan(SdoSegmentHeader::kSize);
  std::fill_n(data.begin(), length, std::byte{0});
  std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(transfer_.position), count, data.begin());
  transfer_.position += count;
  transfer_.toggle = !transfer_.toggle;
  if (response.last) cancel();
  return SdoSegmentHeader::kSize + length;
}

std::size_t SdoServer::initiate_download(const SdoHeader& request, std::span<const std::byte> data, AccessPhase phase,
                                         std::span<std::byte> out) {
  cancel();
  if (!request.expedited()) return start_download(request, data, phase, out);
  const auto value = std::span<const std::byte>(request.data).first(request.expedited_size());
  const SdoAddress address{request.index, request.subindex, request.complete_access()};
  const auto stored = store(address, phase, value, request.size_indicated());
  if (!stored) return abort(request.index, request.subindex, stored.error(), out);
  return confirm_download(address, out);
}

/// Answers with command 60h regardless of the flags of the request: existing slaves do so, and masters compare with it.
std::size_t SdoServer::confirm_download(const SdoAddress& address, std::span<std::byte> out) {
  return put_header({command_byte(SdoResponseCommand::kInitiateDownload), address.index, address.subindex, {}}, out);
}

/// Starts a download whose data begin after the header and continue in segments when they are incomplete. The complete
/// size is always present, even if the request does not indicate it.
std::size_t SdoServer::start_download(const SdoHeader& request, std::span<const std::byte> data, AccessPhase phase,
                                      std::span<std::byte> out) {
  const auto fail = [&](SdoAbort code) { return abort(request.index, request.subindex, code, out); };
  const SdoAddress address{request.index, request.subindex, request.complete_access()};
  const auto most = capacity(address, phase);
  if (!most) return fail(most.error());
  const std::size_t size = request.data_u32();
  if (size > *most || size > buffer_.size()) return fail(SdoAbort::kLengthTooHigh);
  const std::size_t first = std::min(size, data.size());
  std::copy_n(data.begin(), first, buffer_.begin());
  if (first == size) {
    const auto stored = store(address, phase, std::span<const std::byte>(buffer_).first(size), true);
    if (!stored) return fail(stored.error());
  } else {
    transfer_ = {Transfer::Kind::kDownload, address, false, size, first};
  }
  return confirm_download(address, out);
}

std::size_t SdoServer::download_segment(SdoSegmentHeader request, std::span<const std::byte> data, AccessPhase phase,
                                        std::span<std::byte> out) {
  if (transfer_.kind != Transfer::Kind::kDownload) return abort_transfer(SdoAbort::kInvalidCommand, out);
  if (request.toggle != transfer_.toggle) return abort_transfer(SdoAbort::kToggleNotAlternated, out);
  // Only the shortest segment specifies its unused bytes; a longer one has the length that the mailbox header states.
  const std::size_t unused = data.size() == SdoSegmentHeader::kMinData ? request.unused : 0;
  const std::size_t count = data.size() - unused;
  const std::size_t left = transfer_.size - transfer_.position;
  if (count > left) return abort_transfer(SdoAbort::kLengthTooHigh, out);
  std::copy_n(data.begin(), count, buffer_.begin() + static_cast<std::ptrdiff_t>(transfer_.position));
  transfer_.position += count;
  transfer_.toggle = !transfer_.toggle;
  if (request.last) {
    if (count != left) return abort_transfer(SdoAbort::kLengthTooLow, out);
    const auto value = std::span<const std::byte>(buffer_).first(transfer_.size);
    const auto stored = store(transfer_.address, phase, value, true);
    if (!stored) return abort_transfer(stored.error(), out);
    cancel();
  }
  const SdoSegmentHeader response{static_cast<std::uint8_t>(SdoResponseCommand::kDownloadSegment), request.toggle, 0,
                                  false};
  std::fill_n(out.begin(), SdoHeader::kSize, std::byte{0});
  out[0] = static_cast<std::byte>(response.raw());
  return SdoHeader::kSize;
}

}  // namespace driveline::slaves
