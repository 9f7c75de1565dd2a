#include <algorithm>

#include "sdo_transfers.hpp"

namespace driveline::canopen {

SegmentedDownload::SegmentedDownload(std::uint8_t node, SdoObject object, std::span<const std::byte> data,
                                     const SdoOptions& options)
    : SdoTransfer(node, object, options), data_(data.begin(), data.end()) {
  if (!expedited()) {
    queue(sdo_command(SdoRequest::kInitiateDownload, SdoMessage::kSizeIndicated),
          static_cast<std::uint32_t>(data_.size()));
    return;
  }
  SdoMessage message{expedited_command(SdoRequest::kInitiateDownload, data_.size()), object.index, object.subindex, {}};
  std::copy(data_.begin(), data_.end(), message.data.begin());
  queue(message.encode());
}

void SegmentedDownload::answered(const SdoBytes& in) {
  const auto message = *SdoMessage::decode(in);
  const auto specifier = static_cast<SdoResponse>(message.specifier());
  if (initiating()) {
    if (specifier != SdoResponse::kInitiateDownload || !is_about_this(message)) return ignore();
    initiated();
    return expedited() ? finish() : send_segment();
  }
  if (specifier != SdoResponse::kDownloadSegment) {
    // The answer to an initiate message that was given up arrives late.
    const bool initiate = specifier == SdoResponse::kInitiateUpload || specifier == SdoResponse::kInitiateDownload;
    return initiate ? ignore() : refuse(SdoAbort::kInvalidCommand);
  }
  if (SdoSegment::decode(in[0]).toggle != toggle_) return refuse(SdoAbort::kToggleNotAlternated);
  if (complete_) return finish();
  toggle_ = !toggle_;
  send_segment();
}

void SegmentedDownload::send_segment() {
  const std::size_t count = std::min(SdoSegment::kData, data_.size() - position_);
  complete_ = position_ + count == data_.size();
  const SdoSegment header{static_cast<std::uint8_t>(SdoRequest::kDownloadSegment), toggle_,
                          static_cast<std::uint8_t>(SdoSegment::kData - count), complete_};
  SdoBytes out{header.encode()};
  std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(position_), count, out.begin() + 1);
  position_ += count;
  queue(out);
}

}  // namespace driveline::canopen
