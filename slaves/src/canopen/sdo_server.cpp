#include "driveline/slaves/canopen/sdo_server.hpp"

#include <algorithm>

namespace driveline::slaves::cia301 {

using canopen::sdo_command;
using canopen::SdoResponse;
using canopen::SdoSegment;
namespace block = canopen::sdo_block;

namespace {

std::size_t longest_entry(const DictionaryTable& table) noexcept {
  std::size_t longest = sizeof(std::uint64_t);
  for (const auto& row : table.rows()) longest = std::max(longest, byte_size(row));
  return longest;
}

}  // namespace

SdoServer::SdoServer(ObjectDictionary& dictionary, DictionaryOwner& owner, const DeviceOptions& options)
    : dictionary_(&dictionary),
      owner_(&owner),
      block_transfer_(options.block_transfer),
      size_indicated_(options.size_indicated),
      cut_expedited_(options.cut_expedited),
      fill_sign_(options.fill_sign),
      buffer_(longest_entry(dictionary.table())) {}

SdoBytes SdoServer::abort(SdoAbort code) noexcept {
  cancel();
  return canopen::abort_message(address_.index, address_.subindex, code).encode();
}

std::optional<SdoBytes> SdoServer::handle(std::span<const std::byte> request, AccessPhase phase) {
  const auto message = SdoMessage::decode(request);
  if (!message) {
    ++ignored_;
    return std::nullopt;
  }
  SdoBytes raw{};
  std::copy(request.begin(), request.end(), raw.begin());
  if (kind_ == Kind::kBlockDownload && !block_down_.complete() && raw[0] != std::byte{0x80}) {
    // The command of a segment is its sequence number, and has no specifier.
    const auto answer = block_down_.segment(raw);
    return answer ? *answer : std::optional(abort(answer.error()));
  }
  const auto specifier = static_cast<SdoRequest>(message->specifier());
  const bool segment = specifier == SdoRequest::kUploadSegment || specifier == SdoRequest::kDownloadSegment;
  const bool initiate = specifier == SdoRequest::kInitiateUpload || specifier == SdoRequest::kInitiateDownload;
  if (initiate || kind_ == Kind::kNone) {
    address_ = segment ? Address{} : Address{message->index, message->subindex};
  }
  switch (specifier) {
    case SdoRequest::kInitiateUpload:
      return initiate_upload(*message, phase);
    case SdoRequest::kUploadSegment:
      return upload_segment(raw[0]);
    case SdoRequest::kInitiateDownload:
      return initiate_download(*message, phase);
    case SdoRequest::kDownloadSegment:
      return download_segment(request, phase);
    case SdoRequest::kAbort:
      cancel();
      return std::nullopt;
    case SdoRequest::kBlockUpload:
      return block_transfer_ ? block_upload(*message, phase) : abort(SdoAbort::kInvalidCommand);
    case SdoRequest::kBlockDownload:
      return block_transfer_ ? block_download(*message, phase) : abort(SdoAbort::kInvalidCommand);
  }
  return abort(SdoAbort::kInvalidCommand);
}

std::byte SdoServer::filler(std::size_t size) const noexcept {
  const auto* row = dictionary_->table().find(address_.index, address_.subindex);
  const bool negative = (buffer_[size - 1] & std::byte{0x80}) != std::byte{0};
  return fill_sign_ && row != nullptr && is_signed(row->type) && negative ? std::byte{0xFF} : std::byte{0};
}

SdoBytes SdoServer::initiate_upload(const SdoMessage& request, AccessPhase phase) {
  cancel();
  const auto size = dictionary_->upload(request.index, request.subindex, phase, buffer_);
  if (!size) return abort(size.error());
  SdoMessage answer{0, request.index, request.subindex, {}};
  if (*size > 0 && *size <= answer.data.size()) {
    answer.command = size_indicated_ ? canopen::expedited_command(SdoResponse::kInitiateUpload, *size)
                                     : sdo_command(SdoResponse::kInitiateUpload, SdoMessage::kExpedited);
    answer.data.fill(filler(*size));
    std::copy_n(buffer_.begin(), *size, answer.data.begin());
    return answer.encode();
  }
  answer.command = sdo_command(SdoResponse::kInitiateUpload, SdoMessage::kSizeIndicated);
  answer.data = bytes::to_le_bytes(static_cast<std::uint32_t>(*size));
  kind_ = Kind::kUpload;
  toggle_ = false;
  size_ = *size;
  position_ = 0;
  return answer.encode();
}

SdoBytes SdoServer::upload_segment(std::byte command) {
  if (kind_ != Kind::kUpload) return abort(SdoAbort::kInvalidCommand);
  if (SdoSegment::decode(command).toggle != toggle_) return abort(SdoAbort::kToggleNotAlternated);
  const std::size_t count = std::min(SdoSegment::kData, size_ - position_);
  const SdoSegment header{static_cast<std::uint8_t>(SdoResponse::kUploadSegment), toggle_,
                          static_cast<std::uint8_t>(SdoSegment::kData - count), position_ + count == size_};
  SdoBytes out{header.encode()};
  std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(position_), count, out.begin() + 1);
  position_ += count;
  toggle_ = !toggle_;
  if (header.last) cancel();
  return out;
}

/// Returns the number of bytes of the entry, if it can be written now and a value of the announced size fits.
SdoResult<std::size_t> SdoServer::download_room(const SdoMessage& request, AccessPhase phase) {
  const auto row = dictionary_->writable(request.index, request.subindex, phase, *owner_);
  if (!row) return tl::unexpected(row.error());
  const std::size_t room = byte_size(**row);
  if (size_ > room) return tl::unexpected(SdoAbort::kLengthTooHigh);
  return room;
}

SdoResult<void> SdoServer::store(std::span<const std::byte> data, AccessPhase phase, bool size_known) {
  return dictionary_->download(address_.index, address_.subindex, phase, data, *owner_, size_known);
}

SdoBytes SdoServer::initiate_download(const SdoMessage& request, AccessPhase phase) {
  cancel();
  if (request.expedited()) {
    const auto value = std::span<const std::byte>(request.data).first(request.expedited_size());
    const auto stored = store(value, phase, request.size_indicated() && !cut_expedited_);
    if (!stored) return abort(stored.error());
  } else {
    size_ = request.size_indicated() ? request.number() : 0;
    const auto room = download_room(request, phase);
    if (!room) return abort(room.error());
    kind_ = Kind::kDownload;
    toggle_ = false;
    position_ = 0;
  }
  return SdoMessage{sdo_command(SdoResponse::kInitiateDownload), request.index, request.subindex, {}}.encode();
}

SdoBytes SdoServer::download_segment(std::span<const std::byte> request, AccessPhase phase) {
  const SdoSegment header = SdoSegment::decode(request[0]);
  if (kind_ != Kind::kDownload) return abort(SdoAbort::kInvalidCommand);
  if (header.toggle != toggle_) return abort(SdoAbort::kToggleNotAlternated);
  const std::size_t count = SdoSegment::kData - header.unused;
  const std::size_t most = size_ != 0 ? size_ : buffer_.size();
  if (count > most - position_) return abort(SdoAbort::kLengthTooHigh);
  std::copy_n(request.begin() + 1, count, buffer_.begin() + static_cast<std::ptrdiff_t>(position_));
  position_ += count;
  toggle_ = !toggle_;
  if (header.last) {
    if (size_ != 0 && position_ != size_) return abort(SdoAbort::kLengthMismatch);
    const auto stored = store(std::span<const std::byte>(buffer_).first(position_), phase);
    if (!stored) return abort(stored.error());
    cancel();
  }
  const SdoSegment answer{static_cast<std::uint8_t>(SdoResponse::kDownloadSegment), header.toggle, 0, false};
  return {answer.encode()};
}

SdoBytes SdoServer::initiate_block_upload(const SdoMessage& request, AccessPhase phase) {
  cancel();
  address_ = {request.index, request.subindex};
  const auto segments = std::to_integer<std::uint8_t>(request.data[0]);
  if (segments == 0 || segments > block::kMaxSegments) return abort(SdoAbort::kInvalidBlockSize);
  const auto size = dictionary_->upload(request.index, request.subindex, phase, buffer_);
  if (!size) return abort(size.error());
  block_up_.begin(std::span<const std::byte>(buffer_).first(*size), segments,
                  (request.command & block::kCrcSupported) != 0);
  kind_ = Kind::kBlockUpload;
  return SdoMessage{sdo_command(SdoResponse::kBlockUpload, block::kCrcSupported | block::kSizeIndicated), request.index,
                    request.subindex, bytes::to_le_bytes(static_cast<std::uint32_t>(*size))}
      .encode();
}

std::optional<SdoBytes> SdoServer::block_upload(const SdoMessage& request, AccessPhase phase) {
  const unsigned subcommand = request.command & 3U;
  if (subcommand == block::kUploadInitiate) return initiate_block_upload(request, phase);
  if (kind_ != Kind::kBlockUpload) return abort(SdoAbort::kInvalidCommand);
  const SdoBytes raw = request.encode();
  switch (subcommand) {
    case block::kUploadStart:
      block_up_.start();
      return std::nullopt;  // next_segment() has what follows
    case block::kUploadConfirm: {
      const auto confirmed =
          block_up_.confirm(std::to_integer<std::uint8_t>(raw[1]), std::to_integer<std::uint8_t>(raw[2]));
      if (!confirmed) return abort(confirmed.error());
      return block_up_.complete() ? std::optional(block_up_.end()) : std::nullopt;
    }
    default:  // end of the transfer, which has no answer
      if (!block_up_.complete()) return abort(SdoAbort::kInvalidCommand);
      cancel();
      return std::nullopt;
  }
}

std::optional<SdoBytes> SdoServer::next_segment() noexcept {
  return kind_ == Kind::kBlockUpload ? block_up_.next() : std::nullopt;
}

SdoBytes SdoServer::initiate_block_download(const SdoMessage& request, AccessPhase phase) {
  cancel();
  address_ = {request.index, request.subindex};
  size_ = (request.command & block::kSizeIndicated) != 0 ? request.number() : 0;
  const auto room = download_room(request, phase);
  if (!room) return abort(room.error());
  block_down_.begin(std::span(buffer_).first(*room), size_, (request.command & block::kCrcSupported) != 0);
  kind_ = Kind::kBlockDownload;
  return SdoMessage{sdo_command(SdoResponse::kBlockDownload, block::kCrcSupported),
                    request.index,
                    request.subindex,
                    {static_cast<std::byte>(block::kMaxSegments)}}
      .encode();
}

SdoBytes SdoServer::block_download(const SdoMessage& request, AccessPhase phase) {
  if ((request.command & 1U) == block::kDownloadInitiate) return initiate_block_download(request, phase);
  if (kind_ != Kind::kBlockDownload) return abort(SdoAbort::kInvalidCommand);
  const auto data = block_down_.end(request.encode());
  if (!data) return abort(data.error());
  const auto stored = store(*data, phase);
  if (!stored) return abort(stored.error());
  cancel();
  return {static_cast<std::byte>(sdo_command(SdoResponse::kBlockDownload, block::kDownloadEnd))};
}

}  // namespace driveline::slaves::cia301
