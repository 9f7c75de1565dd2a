#include <algorithm>

#include "sdo_transfers.hpp"

namespace driveline::canopen {

namespace block = sdo_block;

namespace {

/// Segments of so many bytes; no data are one segment, too.
std::size_t segments_of(std::size_t bytes) {
  return std::max<std::size_t>(1, (bytes + SdoSegment::kData - 1) / SdoSegment::kData);
}

}  // namespace

BlockDownload::BlockDownload(std::uint8_t node, SdoObject object, std::span<const std::byte> data,
                             const SdoOptions& options)
    : SdoTransfer(node, object, options), data_(data.begin(), data.end()) {
  queue(
      sdo_command(SdoRequest::kBlockDownload, block::kCrcSupported | block::kSizeIndicated | block::kDownloadInitiate),
      static_cast<std::uint32_t>(data_.size()));
}

void BlockDownload::answered(const SdoBytes& in) {
  const auto message = *SdoMessage::decode(in);
  const bool of_block = message.specifier() == static_cast<std::uint8_t>(SdoResponse::kBlockDownload);
  const unsigned subcommand = message.command & 3U;
  if (!of_block) return ignore();
  switch (phase_) {
    case Phase::kInitiate:
      if (subcommand != block::kDownloadInitiate || !is_about_this(message)) return ignore();
      return begin(message);
    case Phase::kSegments:
      return subcommand == block::kDownloadConfirm ? confirmed(in) : ignore();
    case Phase::kEnd:
      return subcommand == block::kDownloadEnd ? finish() : ignore();
  }
}

void BlockDownload::begin(const SdoMessage& message) {
  initiated();
  crc_ = (message.command & block::kCrcSupported) != 0;
  block_segments_ = std::to_integer<std::uint8_t>(message.data[0]);
  if (block_segments_ == 0 || block_segments_ > block::kMaxSegments) return refuse(SdoAbort::kInvalidBlockSize);
  phase_ = Phase::kSegments;
  queue_segment();
}

void BlockDownload::continue_sending() {
  const bool more = sequence_ < block_segments_ && segments_done_ + sequence_ < segments_of(data_.size());
  if (phase_ == Phase::kSegments && more) queue_segment();
}

void BlockDownload::confirmed(const SdoBytes& in) {
  const auto good = std::to_integer<std::uint8_t>(in[1]);
  const auto next_segments = std::to_integer<std::uint8_t>(in[2]);
  if (good > sequence_) return refuse(SdoAbort::kInvalidSequenceNumber);
  if (next_segments == 0 || next_segments > block::kMaxSegments) return refuse(SdoAbort::kInvalidBlockSize);
  fruitless_ = good == 0 ? fruitless_ + 1 : 0;
  if (fruitless_ > options().repeats) return give_up(ClientErrorKind::kNoAnswer);
  segments_done_ += good;
  sequence_ = 0;
  block_segments_ = next_segments;
  if (segments_done_ < segments_of(data_.size())) return queue_segment();
  queue_end();
}

void BlockDownload::queue_segment() {
  const std::size_t position = (segments_done_ + sequence_) * SdoSegment::kData;
  const std::size_t count = std::min(SdoSegment::kData, data_.size() - position);
  ++sequence_;
  SdoBytes out{block::Segment{position + count == data_.size(), sequence_}.encode()};
  std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(position), count, out.begin() + 1);
  queue(out);
}

void BlockDownload::queue_end() {
  phase_ = Phase::kEnd;
  const auto unused = static_cast<unsigned>(segments_of(data_.size()) * SdoSegment::kData - data_.size());
  SdoBytes out{static_cast<std::byte>(sdo_command(SdoRequest::kBlockDownload, unused << 2U | block::kDownloadEnd))};
  if (crc_) bytes::store_le(std::span(out).subspan(1), block::crc16(data_));
  queue(out);
}

}  // namespace driveline::canopen
