#include "rpdo_outputs.hpp"

#include <algorithm>

#include "driveline/canopen_master/bus_budget.hpp"

namespace driveline::canopen {

using std::chrono::nanoseconds;

RpdoOutputs::RpdoOutputs(const PdoImage& image, NodeTable& nodes) : image_(image), nodes_(nodes) {
  for (const auto& place : image.rpdos()) {
    const bool on_change = place.exchange == PdoExchange::kOnChange;
    auto& rpdo = (on_change ? on_change_ : with_sync_).emplace_back();
    rpdo.place = place;
    rpdo.meter = FrameMeter(place.identifier, place.length);
    rpdo.frame = Frame{{place.identifier, false}};
    rpdo.frame.length = place.length;
    if (!on_change) nodes_[place.node].worst_bits += worst_frame_bits(place.length);
  }
}

SendStatus RpdoOutputs::send(CanPort& port, Rpdo& rpdo, std::uint32_t& bits) noexcept {
  const auto bytes = content(rpdo);
  Frame frame = rpdo.frame;
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  const auto status = port.send(frame);
  if (status != SendStatus::kSent) return status;
  rpdo.frame = frame;
  bits += rpdo.meter.bits(bytes);
  return status;
}

std::uint32_t RpdoOutputs::send_with_sync(CanPort& port) noexcept {
  std::uint32_t bits = 0;
  for (auto& rpdo : with_sync_) {
    if (!nodes_[rpdo.place.node].in_use) continue;
    if (send(port, rpdo, bits) == SendStatus::kSent) continue;
    nodes_.note_unsent(rpdo.place.node);
    ++unsent_;
  }
  return bits;
}

bool RpdoOutputs::due(const Rpdo& rpdo, Reason reason, nanoseconds now) const noexcept {
  if (!nodes_[rpdo.place.node].in_use) return false;
  if (reason == Reason::kResend) return now - rpdo.sent_at >= rpdo.place.resend;
  const auto bytes = content(rpdo);
  return rpdo.forced || !std::equal(bytes.begin(), bytes.end(), rpdo.frame.data.begin());
}

std::uint32_t RpdoOutputs::send_on_change(CanPort& port, nanoseconds now, PeriodRoom& room) noexcept {
  std::uint32_t bits = 0;
  for (auto& rpdo : on_change_) rpdo.forced = rpdo.forced || nodes_[rpdo.place.node].begun;
  for (const auto reason : {Reason::kChange, Reason::kResend}) {
    for (std::size_t i = 0; i < on_change_.size(); ++i) {
      const auto place = (turn_ + i) % on_change_.size();
      auto& rpdo = on_change_[place];
      if (!due(rpdo, reason, now)) continue;
      const auto needed = worst_frame_bits(rpdo.place.length);
      const bool sent = room.fits(needed) && send(port, rpdo, bits) == SendStatus::kSent;
      if (!sent) {
        turn_ = place;
        return bits;
      }
      room.use(needed);
      rpdo.forced = false;
      rpdo.sent_at = now;
    }
  }
  return bits;
}

}  // namespace driveline::canopen
