#include <algorithm>

#include "sdo_transfers.hpp"

namespace driveline::canopen {

namespace block = sdo_block;

BlockUpload::BlockUpload(std::uint8_t node, SdoObject object, const SdoOptions& options)
    : SdoTransfer(node, object, options) {
  // Byte 5, the protocol switch threshold, is 0: the node shall not answer with a segmented transfer.
  queue(sdo_command(SdoRequest::kBlockUpload, block::kCrcSupported | block::kUploadInitiate), options.block_segments);
}

void BlockUpload::answered(const SdoBytes& in) {
  switch (phase_) {
    case Phase::kInitiate:
      return begin(*SdoMessage::decode(in));
    case Phase::kSegments:
      return take(in);
    case Phase::kEnd:
      return end(in);
  }
}

void BlockUpload::begin(const SdoMessage& message) {
  const bool initiate = message.specifier() == static_cast<std::uint8_t>(SdoResponse::kBlockUpload) &&
                        (message.command & 1U) == block::kUploadInitiate;
  if (!initiate || !is_about_this(message)) return ignore();
  initiated();
  crc_ = (message.command & block::kCrcSupported) != 0;
  if ((message.command & block::kSizeIndicated) != 0) {
    announced_ = message.number();
    if (*announced_ > options().max_bytes) {
      return refuse(SdoAbort::kOutOfMemory, options().max_bytes, *announced_);
    }
  }
  phase_ = Phase::kSegments;
  queue({static_cast<std::byte>(sdo_command(SdoRequest::kBlockUpload, block::kUploadStart))});
}

void BlockUpload::take(const SdoBytes& in) {
  const auto header = block::Segment::decode(in[0]);
  if (header.sequence == 0 || header.sequence > options().block_segments) {
    return refuse(SdoAbort::kInvalidSequenceNumber);
  }
  any_segment_ = true;
  // What follows a gap is passed over up to the end of the sub-block, and comes again.
  if (header.sequence == last_good_ + 1) {
    last_good_ = header.sequence;
    data_.insert(data_.end(), in.begin() + 1, in.end());
    complete_ = header.last;
    // How many bytes of the last segment count is told at the end.
    if (announced_ && data_.size() >= *announced_ + SdoSegment::kData) {
      return refuse(SdoAbort::kLengthTooHigh, *announced_, data_.size());
    }
    if (data_.size() >= options().max_bytes + SdoSegment::kData) {
      return refuse(SdoAbort::kOutOfMemory, options().max_bytes, data_.size());
    }
  }
  if (header.last || header.sequence == options().block_segments) confirm();
}

bool BlockUpload::repeated() {
  if (phase_ != Phase::kSegments) return false;
  // The last segment of a sub-block was lost, or the message that starts the first one.
  if (any_segment_) {
    confirm();
    return true;
  }
  if (++fruitless_ > options().repeats) return false;
  queue({static_cast<std::byte>(sdo_command(SdoRequest::kBlockUpload, block::kUploadStart))});
  return true;
}

void BlockUpload::confirm() {
  fruitless_ = last_good_ == 0 ? fruitless_ + 1 : 0;
  if (fruitless_ > options().repeats) return give_up(ClientErrorKind::kNoAnswer);
  queue({static_cast<std::byte>(sdo_command(SdoRequest::kBlockUpload, block::kUploadConfirm)),
         static_cast<std::byte>(last_good_), static_cast<std::byte>(options().block_segments)});
  last_good_ = 0;
  if (complete_) phase_ = Phase::kEnd;
}

void BlockUpload::end(const SdoBytes& in) {
  const auto command = std::to_integer<unsigned>(in[0]);
  const bool is_end =
      command >> 5U == static_cast<unsigned>(SdoResponse::kBlockUpload) && (command & 3U) == block::kUploadEnd;
  if (!is_end) return ignore();
  const std::size_t unused = command >> 2U & 7U;
  data_.resize(data_.size() - std::min(unused, data_.size()));
  if (announced_ && data_.size() != *announced_) {
    return refuse(data_.size() < *announced_ ? SdoAbort::kLengthTooLow : SdoAbort::kLengthTooHigh, *announced_,
                  data_.size());
  }
  if (crc_ && block::crc16(data_) != bytes::load_le<std::uint16_t>(std::span(in).subspan(1))) {
    return refuse(SdoAbort::kCrcError);
  }
  finish(std::move(data_));
  queue({static_cast<std::byte>(sdo_command(SdoRequest::kBlockUpload, block::kUploadEnd))});
}

}  // namespace driveline::canopen
