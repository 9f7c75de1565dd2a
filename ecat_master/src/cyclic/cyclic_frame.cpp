#include "driveline/ecat_master/cyclic/cyclic_frame.hpp"

#include <algorithm>

#include "driveline/wire/registers.hpp"

namespace driveline::ecat_master {

CyclicFrame::CyclicFrame(const ProcessSegment* segment, bool with_status) {
  wire::FrameBuilder builder(buffer_, FrameTag{}.to_mac());
  if (with_status) {
    status_place_ =
        builder.add(wire::Command::kBrd, 0, wire::DatagramAddress::physical(0, wire::reg::kAlStatus.address), 2);
  }
  if (segment != nullptr) {
    segment_ = *segment;
    data_place_ =
        builder.add(wire::Command::kLrw, 1,
                    wire::DatagramAddress::logical(ProcessImage::logical_address(segment->offset)), segment->bytes);
  }
  size_ = builder.finish().size();
}

port::SendStatus CyclicFrame::send(port::Port& port, const ProcessImage& image, FrameTag tag) noexcept {
  const auto mac = tag.to_mac();
  std::copy(mac.begin(), mac.end(), buffer_.begin() + 6);
  if (data_place_) {
    const auto outputs = image.outputs().subspan(segment_.offset, segment_.bytes);
    std::copy(outputs.begin(), outputs.end(), buffer_.begin() + static_cast<std::ptrdiff_t>(data_place_->data()));
  }
  tag_ = tag;
  awaited_ = true;
  received_ = false;
  working_counter_ = 0;
  al_status_.reset();
  return port.send(std::span(buffer_).first(size_));
}

bool CyclicFrame::accept(std::span<const std::byte> frame, FrameTag tag, ProcessImage& image) noexcept {
  if (!awaited_ || tag != tag_ || frame.size() < size_) return false;
  // The layout is known, so the answer is checked against it instead of being parsed: every byte of the headers but
  // the flags that slaves may set must be as it was sent.
  auto header_matches = [&](const wire::DatagramPlace& place) {
    const auto sent = wire::DatagramHeader::decode(std::span<const std::byte>(buffer_).subspan(place.header));
    const auto got = wire::DatagramHeader::decode(frame.subspan(place.header));
    return sent && got && sent->command == got->command && sent->index == got->index && sent->length == got->length &&
           sent->more == got->more && sent->address.ado() == got->address.ado();
  };
  if (wire::load_be16(frame.subspan(12, 2)) != wire::kEtherTypeEtherCat) return false;
  if ((status_place_ && !header_matches(*status_place_)) || (data_place_ && !header_matches(*data_place_)))
    return false;
  awaited_ = false;
  received_ = true;
  if (status_place_) {
    al_status_ = LineAlStatus{wire::load_le<std::uint16_t>(frame.subspan(status_place_->working_counter(), 2)),
                              wire::load_le<std::uint16_t>(frame.subspan(status_place_->data(), 2))};
  }
  if (data_place_) {
    working_counter_ = wire::load_le<std::uint16_t>(frame.subspan(data_place_->working_counter(), 2));
    if (valid()) {
      const auto data = frame.subspan(data_place_->data(), segment_.bytes);
      std::copy(data.begin(), data.end(), image.inputs().begin() + static_cast<std::ptrdiff_t>(segment_.offset));
    }
  }
  return true;
}

}  // namespace driveline::ecat_master
