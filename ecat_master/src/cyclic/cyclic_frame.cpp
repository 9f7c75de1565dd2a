#include "driveline/ecat_master/cyclic/cyclic_frame.hpp"

#include <algorithm>

#include "driveline/wire/registers.hpp"

namespace driveline::ecat_master {
namespace {

/// Low byte of an AL status word.
constexpr std::uint8_t al_byte(std::byte raw) noexcept {
  return std::to_integer<std::uint8_t>(raw);
}

/// Below SAFEOP a slave switches its process data sync managers off, or has none configured yet (ETG.1000.6 5.3).
bool below_safe_op(std::uint8_t al_status) noexcept {
  const auto state = wire::AlStatus::from_raw(al_status).state;
  return state == wire::AlState::kInit || state == wire::AlState::kPreOp || state == wire::AlState::kBootstrap;
}

/// A slave that has left OP because of an error keeps its output sync manager off until the error is acknowledged
/// (ETG.1000.6, error indication).
bool safe_op_with_error(std::uint8_t al_status) noexcept {
  const auto status = wire::AlStatus::from_raw(al_status);
  return status.state == wire::AlState::kSafeOp && status.error;
}

void copy(std::span<const std::byte> from, std::span<std::byte> to, std::size_t offset, std::size_t bytes) noexcept {
  const auto part = from.subspan(0, bytes);
  std::copy(part.begin(), part.end(), to.begin() + static_cast<std::ptrdiff_t>(offset));
}

}  // namespace

CyclicFrame::CyclicFrame(const ProcessImage& image, std::size_t number, bool with_drift) {
  wire::FrameBuilder builder(buffer_, FrameTag{}.to_mac());
  std::uint8_t index = 0;
  if (number == 0) {
    const auto address = wire::DatagramAddress::physical(0, wire::reg::kAlStatus.address);
    status_place_ = builder.add(wire::Command::kBrd, index++, address, 2);
  }
  if (with_drift) drift_place_ = builder.add(wire::Command::kNop, index++, {}, dc::DriftDatagram::kBytes);
  const auto datagrams = image.datagrams();
  std::size_t share = 0;
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    const std::size_t first_share = share;
    while (share < image.shares().size() && image.shares()[share].datagram == i) ++share;
    if (datagrams[i].frame != number) continue;
    const auto address = wire::DatagramAddress::logical(ProcessImage::logical_address(datagrams[i].offset));
    const auto place = builder.add(datagrams[i].command, index++, address, datagrams[i].bytes);
    if (parts_.empty()) {
      first_datagram_ = i;
      group_ = datagrams[i].group;
    }
    parts_.push_back({datagrams[i], place.value(), first_share, share - first_share, {}, {}, false});
    expected_working_counter_ =
        static_cast<std::uint16_t>(expected_working_counter_ + datagrams[i].expected_working_counter);
  }
  results_.resize(parts_.size());
  size_ = builder.finish().size();
  collect_status_places(image);
}

void CyclicFrame::collect_status_places(const ProcessImage& image) {
  for (auto& part : parts_) {
    for (const auto& share : image.shares().subspan(part.first_share, part.share_count)) {
      const auto& place = image.places()[share.slave];
      if (place.input_datagram != share.datagram) continue;
      for (const auto offset : {place.al_status_offset, place.mailbox_offset}) {
        if (offset == ProcessDataPlace::kNone) continue;
        part.status_places.push_back(static_cast<std::uint32_t>(part.place.data() + offset - part.datagram.offset));
      }
    }
    part.status_bytes.resize(part.status_places.size());
  }
}

/// Stores the status bytes of this answer; returns whether one differs from the previous answer.
bool CyclicFrame::status_changed(Part& part, std::span<const std::byte> frame) noexcept {
  auto difference = std::byte{0};
  for (std::size_t i = 0; i < part.status_places.size(); ++i) {
    const auto status = frame[part.status_places[i]];
    difference |= status ^ part.status_bytes[i];
    part.status_bytes[i] = status;
  }
  return difference != std::byte{0};
}

void CyclicFrame::set_drift(const dc::DriftDatagram& drift) noexcept {
  const auto raw = std::span(buffer_).subspan(drift_place_->header).first<wire::DatagramHeader::kSize>();
  auto header = wire::DatagramHeader::decode(raw).value_or(wire::DatagramHeader{});
  header.command = drift.command;
  header.address = drift.address;
  header.encode(raw);
  bytes::store_le<std::uint32_t>(std::span(buffer_).subspan(drift_place_->data(), drift_place_->length), drift.time);
}

void CyclicFrame::prepare(const ProcessImage& image, bool zero_outputs) noexcept {
  zero_outputs_ = zero_outputs;
  for (const auto& part : parts_) {
    if (part.datagram.command == wire::Command::kLrd) continue;
    if (zero_outputs) {
      const auto data = std::span<std::byte>(buffer_).subspan(part.place.data(), part.datagram.bytes);
      std::fill(data.begin(), data.end(), std::byte{0});
    } else {
      copy(image.outputs().subspan(part.datagram.offset), buffer_, part.place.data(), part.datagram.bytes);
    }
  }
}

port::SendStatus CyclicFrame::send(port::Port& port, FrameTag tag) noexcept {
  const auto mac = tag.to_mac();
  std::copy(mac.begin(), mac.end(), buffer_.begin() + 6);
  tag_ = tag;
  awaited_ = true;
  received_ = false;
  std::fill(results_.begin(), results_.end(), DatagramResult{});
  al_status_.reset();
  drift_.reset();
  return port.send(std::span(buffer_).first(size_));
}

/// The layout is known, so the answer is compared with it instead of being parsed: every byte of the headers must be as
/// it was sent, except the flags that slaves may set.
bool CyclicFrame::is_answer(std::span<const std::byte> frame) const noexcept {
  const auto header_matches = [&](const wire::DatagramPlace& place) {
    const auto sent = wire::DatagramHeader::decode(std::span<const std::byte>(buffer_).subspan(place.header));
    const auto got = wire::DatagramHeader::decode(frame.subspan(place.header));
    return sent && got && sent->command == got->command && sent->index == got->index && sent->length == got->length &&
           sent->more == got->more && sent->address.ado() == got->address.ado();
  };
  if (frame.size() < size_ || bytes::load_be16(frame.subspan(12, 2)) != wire::kEtherTypeEtherCat) return false;
  if (status_place_ && !header_matches(*status_place_)) return false;
  if (drift_place_ && !header_matches(*drift_place_)) return false;
  return std::all_of(parts_.begin(), parts_.end(), [&](const Part& part) { return header_matches(part.place); });
}

bool CyclicFrame::accept(std::span<const std::byte> frame, FrameTag tag, ProcessImage& image,
                         std::span<SlaveCondition> conditions) noexcept {
  if (!awaited_ || tag != tag_ || !is_answer(frame)) return false;
  awaited_ = false;
  received_ = true;
  if (status_place_) {
    al_status_ = LineAlStatus{bytes::load_le<std::uint16_t>(frame.subspan(status_place_->working_counter(), 2)),
                              bytes::load_le<std::uint16_t>(frame.subspan(status_place_->data(), 2))};
  }
  if (drift_place_) {
    drift_ = dc::DriftAnswer{bytes::load_le<std::uint32_t>(frame.subspan(drift_place_->data(), drift_place_->length)),
                             bytes::load_le<std::uint16_t>(frame.subspan(drift_place_->working_counter(), 2))};
  }
  steady_ = true;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    auto& part = parts_[i];
    auto& result = results_[i];
    result.received = true;
    result.working_counter = bytes::load_le<std::uint16_t>(frame.subspan(part.place.working_counter(), 2));
    result.complete = result.working_counter == part.datagram.expected_working_counter;
    const bool changed = status_changed(part, frame);
    const bool same = result.complete && part.was_complete && !changed;
    part.was_complete = result.complete;
    steady_ = steady_ && same;
    if (part.datagram.command == wire::Command::kLwr) continue;
    const auto data = frame.subspan(part.place.data(), part.place.length);
    if (same) {
      result.good = true;
      copy(data, image.inputs(), part.datagram.offset, part.datagram.bytes);
    } else {
      take(part, result, data, image, conditions);
    }
  }
  return true;
}

/// A complete working counter confirms everything. Otherwise the status bytes tell which slaves are missing, and the
/// shares of the others must add up exactly; then the inputs of each present slave are copied, and those of missing
/// slaves stay unchanged.
void CyclicFrame::take(const Part& part, DatagramResult& result, std::span<const std::byte> data, ProcessImage& image,
                       std::span<SlaveCondition> conditions) noexcept {
  const auto& datagram = part.datagram;
  const auto shares = image.shares().subspan(part.first_share, part.share_count);
  for (const auto& share : shares) {
    const auto& place = image.places()[share.slave];
    if (place.al_status_offset == ProcessDataPlace::kNone || place.input_datagram != share.datagram) continue;
    auto& condition = conditions[share.slave];
    condition.al_status = al_byte(data[place.al_status_offset - datagram.offset]);
    condition.absent = !result.complete && condition.al_status == 0;
    condition.down = !result.complete && !condition.absent && below_safe_op(condition.al_status);
    condition.outputs_off = safe_op_with_error(condition.al_status);
  }
  explain(part, image, conditions, result);
  if (result.complete) return copy(data, image.inputs(), datagram.offset, datagram.bytes);
  if (!result.good) return;
  for (const auto& share : shares) {
    const auto& place = image.places()[share.slave];
    const auto& condition = conditions[share.slave];
    if (condition.absent || condition.down || condition.recovering || place.input_datagram != share.datagram) continue;
    copy(data.subspan(place.input_offset - datagram.offset), image.inputs(), place.input_offset, place.input_bytes);
    if (place.mailbox_offset == ProcessDataPlace::kNone) continue;
    image.inputs()[place.mailbox_offset] = data[place.mailbox_offset - datagram.offset];
  }
}

/// Compares the working counter with the sum of the slaves that are certainly present, and with that sum plus the
/// slaves in an unknown state.
void CyclicFrame::explain(const Part& part, const ProcessImage& image, std::span<const SlaveCondition> conditions,
                          DatagramResult& result) const noexcept {
  result.good = result.complete;
  if (result.complete) return;
  unsigned here = 0;
  unsigned absent = 0;
  unsigned uncertain = 0;
  bool any_present = false;
  for (const auto& share : image.shares().subspan(part.first_share, part.share_count)) {
    const auto& condition = conditions[share.slave];
    if (condition.recovering || condition.down) {
      uncertain += share.count;
    } else if (condition.absent) {
      absent += share.count;
    } else {
      // An LRW counts 1 for reading and 2 for writing.
      const unsigned reads = part.datagram.command == wire::Command::kLwr ? 0U : share.count % 2U;
      const unsigned certain = condition.outputs_off ? reads : share.count;
      here += certain;
      uncertain += share.count - certain;
      any_present = true;
    }
  }
  const unsigned counter = result.working_counter;
  result.good = counter >= here && counter <= here + uncertain && any_present;
  result.disturbed = counter < here + absent || counter > here + absent + uncertain;
}

void CyclicFrame::judge_outputs(const ProcessImage& image, std::span<const SlaveCondition> conditions) noexcept {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    auto& result = results_[i];
    if (parts_[i].datagram.command != wire::Command::kLwr || !result.received) continue;
    explain(parts_[i], image, conditions, result);
  }
}

bool CyclicFrame::valid() const noexcept {
  return received_ &&
         std::none_of(results_.begin(), results_.end(), [](const auto& result) { return result.disturbed; });
}

std::uint16_t CyclicFrame::working_counter() const noexcept {
  unsigned sum = 0;
  for (const auto& result : results_) sum += result.working_counter;
  return static_cast<std::uint16_t>(sum);
}

}  // namespace driveline::ecat_master
