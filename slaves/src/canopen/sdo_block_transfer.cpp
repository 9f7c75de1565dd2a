#include "driveline/slaves/canopen/sdo_block_transfer.hpp"

namespace driveline::slaves::cia301 {

using canopen::SdoResponse;
using canopen::SdoSegment;
namespace block = canopen::sdo_block;

void SdoBlockDownload::begin(std::span<std::byte> buffer, std::size_t size, bool crc) noexcept {
  *this = {};
  buffer_ = buffer;
  announced_ = size;
  crc_ = crc;
}

tl::expected<std::optional<SdoBytes>, SdoAbort> SdoBlockDownload::segment(const SdoBytes& in) noexcept {
  const auto header = block::Segment::decode(in[0]);
  if (header.sequence == 0) return tl::unexpected(SdoAbort::kInvalidSequenceNumber);
  // What follows a gap is passed over up to the end of the sub-block, and comes again.
  if (header.sequence == last_good_ + 1) {
    last_good_ = header.sequence;
    // The last segment may be longer than the data: how many of its bytes count is known at the end.
    const std::size_t room = buffer_.size() - received_;
    if (room == 0) return tl::unexpected(SdoAbort::kLengthTooHigh);
    std::copy_n(in.begin() + 1, std::min(room, SdoSegment::kData),
                buffer_.begin() + static_cast<std::ptrdiff_t>(received_));
    received_ += SdoSegment::kData;
    if (received_ > buffer_.size() && !header.last) return tl::unexpected(SdoAbort::kLengthTooHigh);
    complete_ = header.last;
  }
  if (!header.last && header.sequence != block::kMaxSegments) return std::nullopt;
  SdoBytes answer{static_cast<std::byte>(canopen::sdo_command(SdoResponse::kBlockDownload, block::kDownloadConfirm)),
                  static_cast<std::byte>(last_good_), static_cast<std::byte>(block::kMaxSegments)};
  last_good_ = 0;
  return answer;
}

tl::expected<std::span<const std::byte>, SdoAbort> SdoBlockDownload::end(const SdoBytes& in) noexcept {
  const std::size_t unused = std::to_integer<std::size_t>(in[0]) >> 2 & 7U;
  if (unused > received_) return tl::unexpected(SdoAbort::kLengthTooLow);
  const std::size_t size = received_ - unused;
  if (size > buffer_.size()) return tl::unexpected(SdoAbort::kLengthTooHigh);
  if (announced_ != 0 && size != announced_) return tl::unexpected(SdoAbort::kLengthMismatch);
  const auto data = std::span<const std::byte>(buffer_).first(size);
  if (crc_ && block::crc16(data) != bytes::load_le<std::uint16_t>(std::span(in).subspan(1))) {
    return tl::unexpected(SdoAbort::kCrcError);
  }
  return data;
}

void SdoBlockUpload::begin(std::span<const std::byte> data, std::uint8_t segments, bool crc) noexcept {
  *this = {};
  data_ = data;
  segments_ = segments;
  crc_ = crc;
}

std::optional<SdoBytes> SdoBlockUpload::next() noexcept {
  const std::size_t position = confirmed_ + sequence_ * SdoSegment::kData;
  if (!sending_ || sequence_ == segments_ || position >= data_.size()) return std::nullopt;
  const std::size_t count = std::min(SdoSegment::kData, data_.size() - position);
  ++sequence_;
  SdoBytes out{block::Segment{position + count == data_.size(), sequence_}.encode()};
  std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(position), count, out.begin() + 1);
  return out;
}

tl::expected<void, SdoAbort> SdoBlockUpload::confirm(std::uint8_t sequence, std::uint8_t segments) noexcept {
  if (sequence > sequence_) return tl::unexpected(SdoAbort::kInvalidSequenceNumber);
  if (segments == 0 || segments > block::kMaxSegments) return tl::unexpected(SdoAbort::kInvalidBlockSize);
  confirmed_ += sequence * SdoSegment::kData;
  segments_ = segments;
  sequence_ = 0;
  complete_ = confirmed_ >= data_.size();
  return {};
}

SdoBytes SdoBlockUpload::end() const noexcept {
  const std::size_t in_last = data_.size() % SdoSegment::kData;
  const std::size_t unused = in_last == 0 ? 0 : SdoSegment::kData - in_last;
  SdoBytes out{static_cast<std::byte>(
      canopen::sdo_command(SdoResponse::kBlockUpload, static_cast<unsigned>(unused) << 2 | block::kUploadEnd))};
  if (crc_) bytes::store_le(std::span(out).subspan(1), block::crc16(data_));
  return out;
}

}  // namespace driveline::slaves::cia301
