#include "support/cyclic_frame.hpp"

#include <algorithm>

#include "driveline/port/port.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::bench {
namespace {

using ecat_master::ProcessImage;

constexpr std::byte kInOp{0x08};

void add_al_status(CyclicFrame& frame, wire::FrameBuilder& builder, std::size_t slaves) {
  const auto place = builder.add(wire::Command::kBrd, 0, wire::DatagramAddress::physical(0, 0x0130), 2).value();
  frame.changes.push_back({place.data(), kInOp});
  frame.changes.push_back({place.working_counter(), static_cast<std::byte>(slaves)});
}

void add_process_data(CyclicFrame& frame, wire::FrameBuilder& builder, const ProcessImage& image,
                      const ecat_master::ProcessDatagram& datagram) {
  const auto address = wire::DatagramAddress::logical(ProcessImage::logical_address(datagram.offset));
  const auto place = builder.add(datagram.command, 1, address, datagram.bytes).value();
  frame.changes.push_back({place.working_counter(), static_cast<std::byte>(datagram.expected_working_counter & 0xFF)});
  frame.changes.push_back(
      {place.working_counter() + 1, static_cast<std::byte>(datagram.expected_working_counter >> 8)});
  for (const auto& slave : image.places()) {
    if (slave.al_status_offset < datagram.offset || slave.al_status_offset >= datagram.offset + datagram.bytes)
      continue;
    frame.changes.push_back({place.data() + slave.al_status_offset - datagram.offset, kInOp});
  }
}

}  // namespace

const CyclicFrame::Change* CyclicFrame::missing_in(std::span<const std::byte> answer) const noexcept {
  const auto missing = std::find_if(changes.begin(), changes.end(), [answer](const Change& change) {
    return change.offset >= answer.size() || answer[change.offset] != change.value;
  });
  return missing == changes.end() ? nullptr : &*missing;
}

std::vector<CyclicFrame> cyclic_frames(const ProcessImage& image) {
  std::vector<CyclicFrame> frames;
  for (std::size_t number = 0; number < image.frame_count(); ++number) {
    auto& frame = frames.emplace_back();
    std::vector<std::byte> buffer(port::kMaxFrameBytes);
    wire::FrameBuilder builder(buffer, {});
    if (number == 0) add_al_status(frame, builder, image.places().size());
    for (const auto& datagram : image.datagrams()) {
      if (datagram.frame == number) add_process_data(frame, builder, image, datagram);
    }
    const auto built = builder.finish();
    frame.bytes.assign(built.begin(), built.end());
  }
  return frames;
}

}  // namespace driveline::bench
