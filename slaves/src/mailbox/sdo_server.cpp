#include "driveline/slaves/mailbox/sdo_server.hpp"

#include <algorithm>

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

}  // namespace

SdoServer::SdoServer(ObjectDictionary& dictionary, DictionaryOwner& owner)
    : dictionary_(&dictionary), owner_(&owner), buffer_(kMaxObject) {}

std::size_t SdoServer::handle(std::span<const std::byte> request, wire::AlState state, std::span<std::byte> out) {
  const auto header = SdoHeader::decode(request);
  if (!header) return abort(0, 0, SdoAbort::kInvalidCommand, out);
  const auto segment = SdoSegmentHeader::from_raw(header->command);
  switch (static_cast<SdoRequestCommand>(header->specifier())) {
    case SdoRequestCommand::kInitiateUpload:
      return initiate_upload(*header, state, out);
    case SdoRequestCommand::kUploadSegment:
      return upload_segment(segment, out);
    case SdoRequestCommand::kInitiateDownload:
      return initiate_download(*header, request.subspan(SdoHeader::kSize), state, out);
    case SdoRequestCommand::kDownloadSegment:
      return download_segment(segment, request.subspan(SdoSegmentHeader::kSize), state, out);
    case SdoRequestCommand::kAbort:
      cancel();
      return 0;
  }
  return abort(header->index, header->subindex, SdoAbort::kInvalidCommand, out);
}

std::size_t SdoServer::abort(std::uint16_t index, std::uint8_t subindex, SdoAbort code, std::span<std::byte> out) {
  cancel();
  return put_header(
      {command_byte(SdoResponseCommand::kAbort), index, subindex, wire::to_le_bytes(static_cast<std::uint32_t>(code))},
      out);
}

std::size_t SdoServer::abort_transfer(SdoAbort code, std::span<std::byte> out) {
  return abort(transfer_.index, transfer_.subindex, code, out);
}

std::size_t SdoServer::initiate_upload(const SdoHeader& request, wire::AlState state, std::span<std::byte> out) {
  cancel();
  if (request.complete_access()) return abort(request.index, request.subindex, SdoAbort::kNoCompleteAccess, out);
  const auto size = dictionary_->upload(request.index, request.subindex, state, buffer_);
  if (!size) return abort(request.index, request.subindex, size.error(), out);

  SdoHeader response{0, request.index, request.subindex, {}};
  if (*size > 0 && *size <= response.data.size()) {
    response.command = wire::expedited_command(static_cast<std::uint8_t>(SdoResponseCommand::kInitiateUpload), *size);
    std::copy_n(buffer_.begin(), *size, response.data.begin());
    return put_header(response, out);
  }
  response.command = command_byte(SdoResponseCommand::kInitiateUpload, SdoHeader::kSizeIndicated);
  response.data = wire::to_le_bytes(static_cast<std::uint32_t>(*size));
  const std::size_t first = std::min(*size, out.size() - SdoHeader::kSize);
  std::copy_n(buffer_.begin(), first, out.begin() + SdoHeader::kSize);
  if (first < *size) {
    transfer_ = {Transfer::Kind::kUpload, request.index, request.subindex, false, *size, first};
  }
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

std::size_t SdoServer::initiate_download(const SdoHeader& request, std::span<const std::byte> data, wire::AlState state,
                                         std::span<std::byte> out) {
  cancel();
  if (request.complete_access()) return abort(request.index, request.subindex, SdoAbort::kNoCompleteAccess, out);
  if (!request.expedited()) return start_download(request, data, state, out);
  const auto value = std::span<const std::byte>(request.data).first(request.expedited_size());
  const auto stored =
      dictionary_->download(request.index, request.subindex, state, value, *owner_, request.size_indicated());
  if (!stored) return abort(request.index, request.subindex, stored.error(), out);
  return put_header({command_byte(SdoResponseCommand::kInitiateDownload), request.index, request.subindex, {}}, out);
}

/// A download whose data begin behind the header and go on in segments when they are not complete.
std::size_t SdoServer::start_download(const SdoHeader& request, std::span<const std::byte> data, wire::AlState state,
                                      std::span<std::byte> out) {
  const auto fail = [&](SdoAbort code) { return abort(request.index, request.subindex, code, out); };
  const auto row = dictionary_->writable(request.index, request.subindex, state, *owner_);
  if (!row) return fail(row.error());
  if (!request.size_indicated()) return fail(SdoAbort::kInvalidCommand);
  const std::size_t size = request.data_u32();
  if (size > byte_size(**row) || size > buffer_.size()) return fail(SdoAbort::kLengthTooHigh);
  const std::size_t first = std::min(size, data.size());
  std::copy_n(data.begin(), first, buffer_.begin());
  if (first == size) {
    const auto value = std::span<const std::byte>(buffer_).first(size);
    const auto stored = dictionary_->download(request.index, request.subindex, state, value, *owner_);
    if (!stored) return fail(stored.error());
  } else {
    transfer_ = {Transfer::Kind::kDownload, request.index, request.subindex, false, size, first};
  }
  return put_header({command_byte(SdoResponseCommand::kInitiateDownload), request.index, request.subindex, {}}, out);
}

std::size_t SdoServer::download_segment(SdoSegmentHeader request, std::span<const std::byte> data, wire::AlState state,
                                        std::span<std::byte> out) {
  if (transfer_.kind != Transfer::Kind::kDownload) return abort_transfer(SdoAbort::kInvalidCommand, out);
  if (request.toggle != transfer_.toggle) return abort_transfer(SdoAbort::kToggleNotAlternated, out);
  // Only the shortest segment counts its unused bytes; a longer one is as long as its mailbox says.
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
    const auto stored = dictionary_->download(transfer_.index, transfer_.subindex, state, value, *owner_);
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
