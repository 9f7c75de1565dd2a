#include "sdo_transfers.hpp"

namespace driveline::canopen {

SegmentedUpload::SegmentedUpload(std::uint8_t node, SdoObject object, const SdoOptions& options)
    : SdoTransfer(node, object, options) {
  queue(sdo_command(SdoRequest::kInitiateUpload));
}

void SegmentedUpload::answered(const SdoBytes& in) {
  if (initiating()) {
    begin(*SdoMessage::decode(in));
  } else {
    take(in);
  }
}

void SegmentedUpload::begin(const SdoMessage& message) {
  if (message.specifier() != static_cast<std::uint8_t>(SdoResponse::kInitiateUpload) || !is_about_this(message)) {
    return ignore();
  }
  initiated();
  if (message.expedited()) {
    const auto value = std::span(message.data).first(message.expedited_size());
    return finish({value.begin(), value.end()});
  }
  if (message.size_indicated()) {
    announced_ = message.number();
    if (*announced_ > options().max_bytes) {
      return refuse(SdoAbort::kOutOfMemory, options().max_bytes, *announced_);
    }
  }
  ask_for_segment();
}

void SegmentedUpload::take(const SdoBytes& in) {
  const auto header = SdoSegment::decode(in[0]);
  if (header.specifier != static_cast<std::uint8_t>(SdoResponse::kUploadSegment)) {
    // The answer to an initiate message that was given up arrives late.
    const bool initiate = header.specifier == static_cast<std::uint8_t>(SdoResponse::kInitiateUpload) ||
                          header.specifier == static_cast<std::uint8_t>(SdoResponse::kInitiateDownload);
    return initiate ? ignore() : refuse(SdoAbort::kInvalidCommand);
  }
  if (header.toggle != toggle_) return refuse(SdoAbort::kToggleNotAlternated);
  const std::size_t count = SdoSegment::kData - header.unused;
  data_.insert(data_.end(), in.begin() + 1, in.begin() + 1 + static_cast<std::ptrdiff_t>(count));
  if (announced_ && data_.size() > *announced_) return refuse(SdoAbort::kLengthTooHigh, *announced_, data_.size());
  if (data_.size() > options().max_bytes) {
    return refuse(SdoAbort::kOutOfMemory, options().max_bytes, data_.size());
  }
  if (header.last) {
    if (announced_ && data_.size() < *announced_) return reject(SdoAbort::kLengthTooLow, *announced_, data_.size());
    return finish(std::move(data_));
  }
  // A server that sends empty segments would never end.
  if (count == 0) return refuse(SdoAbort::kGeneralError);
  toggle_ = !toggle_;
  ask_for_segment();
}

void SegmentedUpload::ask_for_segment() {
  queue({SdoSegment{static_cast<std::uint8_t>(SdoRequest::kUploadSegment), toggle_, 0, false}.encode()});
}

}  // namespace driveline::canopen
