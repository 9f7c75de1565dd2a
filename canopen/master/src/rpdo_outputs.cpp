#include "rpdo_outputs.hpp"

#include <algorithm>

#include "driveline/canopen_master/bus_budget.hpp"

namespace driveline::canopen {

using std::chrono::nanoseconds;

namespace {

constexpr std::uint16_t kControlWord = 0x6040;
/// Objects of the drives of a node, from 6000h on, are this far apart (CiA 402-1).
constexpr std::uint16_t kNextDrive = 0x800;

bool has_control_word(const motion::PdoMapping& mapping) {
  return std::any_of(mapping.objects.begin(), mapping.objects.end(), [](const motion::MappedObject& object) {
    return object.index >= kControlWord && (object.index - kControlWord) % kNextDrive == 0;
  });
}

}  // namespace

RpdoOutputs::RpdoOutputs(const PdoImage& image, NodeTable& nodes)
    : image_(image), nodes_(nodes), on_change_(nodes.size()) {
  std::vector<std::size_t> seen(nodes.size());
  for (const auto& place : image.rpdos()) {
    const auto& mapping = image.configuration(place.node).outputs[seen[place.node]++];
    Rpdo rpdo;
    rpdo.place = place;
    rpdo.meter = FrameMeter(place.identifier, place.length);
    rpdo.frame = Frame{{place.identifier, false}};
    rpdo.frame.length = place.length;
    rpdo.commands = has_control_word(mapping);
    if (place.exchange == PdoExchange::kOnChange) {
      on_change_[place.node].rpdos.push_back(rpdo);
    } else {
      with_sync_.push_back(rpdo);
      nodes_[place.node].worst_bits += worst_frame_bits(place.length);
    }
  }
  for (auto& group : on_change_) {
    std::stable_partition(group.rpdos.begin(), group.rpdos.end(), [](const Rpdo& rpdo) { return !rpdo.commands; });
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

/// Returns false if an RPDO that is due could not be sent.
bool RpdoOutputs::send_due(Group& group, Pass& pass) noexcept {
  bool others_changed = false;
  bool command_waits = false;
  for (auto& rpdo : group.rpdos) {
    if (!due(rpdo, pass.reason, pass.now)) continue;
    if (rpdo.commands && others_changed && !group.waited) {
      command_waits = true;
      continue;
    }
    const auto needed = worst_frame_bits(rpdo.place.length);
    if (!pass.room.fits(needed) || send(pass.port, rpdo, pass.bits) != SendStatus::kSent) return false;
    pass.room.use(needed);
    // A node that has come into use gets all of them, and none tells of another.
    others_changed = others_changed || (pass.reason == Reason::kChange && !rpdo.forced);
    rpdo.forced = false;
    rpdo.sent_at = pass.now;
  }
  if (pass.reason == Reason::kChange) group.waited = command_waits;
  return true;
}

std::uint32_t RpdoOutputs::send_on_change(CanPort& port, nanoseconds now, PeriodRoom& room) noexcept {
  for (std::size_t node = 0; node < on_change_.size(); ++node) {
    if (!nodes_[node].begun) continue;
    for (auto& rpdo : on_change_[node].rpdos) rpdo.forced = true;
  }
  Pass pass{port, now, room, Reason::kChange};
  for (const auto reason : {Reason::kChange, Reason::kResend}) {
    pass.reason = reason;
    for (std::size_t i = 0; i < on_change_.size(); ++i) {
      const auto node = (turn_ + i) % on_change_.size();
      if (send_due(on_change_[node], pass)) continue;
      turn_ = node;
      return pass.bits;
    }
  }
  return pass.bits;
}

}  // namespace driveline::canopen
