#include "driveline/ecat_master/process_image.hpp"

#include <algorithm>

namespace driveline::ecat_master {

Result<ProcessImage> ProcessImage::lay_out(std::span<const ProcessDataDemand> demands) {
  ProcessImage image;
  std::size_t end = 0;
  for (std::size_t i = 0; i < demands.size(); ++i) {
    const auto& demand = demands[i];
    const std::size_t bytes = std::max(demand.output_bytes, demand.input_bytes);
    if (bytes > kMaxSegmentBytes) {
      Error error;
      error.kind = ErrorKind::kProcessDataSize;
      error.slave = static_cast<std::uint16_t>(i);
      error.expected = kMaxSegmentBytes;
      error.received = static_cast<std::uint32_t>(bytes);
      return tl::unexpected(error);
    }
    if (image.segments_.empty() || image.segments_.back().bytes + bytes > kMaxSegmentBytes) {
      image.segments_.push_back({end, 0, 0});
    }
    auto& segment = image.segments_.back();
    image.places_.push_back({end, image.segments_.size() - 1, demand.output_bytes, demand.input_bytes});
    segment.bytes += bytes;
    segment.expected_working_counter = static_cast<std::uint16_t>(
        segment.expected_working_counter + (demand.output_bytes > 0 ? 2 : 0) + (demand.input_bytes > 0 ? 1 : 0));
    end += bytes;
  }
  // Slaves without process data leave no segment behind.
  std::erase_if(image.segments_, [](const ProcessSegment& s) { return s.bytes == 0; });
  image.outputs_.resize(end);
  image.inputs_.resize(end);
  return image;
}

std::uint64_t wire_time_ns(const ProcessImage& image, std::size_t slaves, std::uint64_t slave_delay_ns) {
  constexpr std::uint64_t kNsPerByte = 80;
  constexpr std::uint64_t kPreambleFcsGap = 8 + 4 + 12;
  // The first frame carries the broadcast read of the AL status, also when there are no process data.
  std::uint64_t bytes = 0;
  std::uint64_t frame = wire::kDatagramsOffset + wire::DatagramHeader::kOverhead + 2;
  for (std::size_t i = 0; i == 0 || i < image.segments().size(); ++i) {
    if (i < image.segments().size()) frame += wire::DatagramHeader::kOverhead + image.segments()[i].bytes;
    bytes += std::max<std::uint64_t>(frame, wire::kMinFrameBytes) + kPreambleFcsGap;
    frame = wire::kDatagramsOffset;
  }
  return bytes * kNsPerByte + slaves * slave_delay_ns;
}

}  // namespace driveline::ecat_master
