#include "rpdo_outputs.hpp"

#include <algorithm>
#include <utility>

#include "driveline/canopen_master/bus_budget.hpp"
#include "few_bytes.hpp"

namespace driveline::canopen {

using std::chrono::nanoseconds;

namespace {

constexpr std::uint16_t kControlWord = 0x6040;
/// Objects of the drives of a node, from 6000h on, are this far apart (CiA 402-1).
constexpr std::uint16_t kNextDrive = 0x800;

/// The first time after `now` that is at `phase` of an interval.
nanoseconds next_at(nanoseconds phase, nanoseconds interval, nanoseconds now) noexcept {
  if (interval.count() <= 0) return now;
  auto since = (now - phase) % interval;
  if (since.count() < 0) since += interval;
  return now + interval - since;
}

/// The first byte of the first control word; none: there is none.
std::optional<std::size_t> control_word_at(const motion::PdoMapping& mapping) {
  std::size_t bits = 0;
  for (const auto& object : mapping.objects) {
    if (object.index >= kControlWord && (object.index - kControlWord) % kNextDrive == 0) return bits / 8;
    bits += object.bits;
  }
  return std::nullopt;
}

/// Whether the control word tells its drive to act on setpoints: Enable operation, without halt (CiA 402-2).
bool operates(std::span<const std::byte> control_word) noexcept {
  constexpr std::byte kEnableOperation{0x0F};
  constexpr std::byte kHalt{0x01};
  if (control_word.size() < 2) return false;
  return (control_word[0] & kEnableOperation) == kEnableOperation && (control_word[1] & kHalt) == std::byte{0};
}

}  // namespace

RpdoOutputs::RpdoOutputs(const PdoImage& image, NodeTable& nodes)
    : image_(image), nodes_(nodes), on_change_(nodes.size()) {
  std::vector<std::size_t> seen(nodes.size());
  for (const auto& place : image.rpdos()) {
    const auto& mapping = image.configuration(place.node).outputs[seen[place.node]++];
    Rpdo rpdo;
    rpdo.place = place;
    rpdo.frame = Frame{{place.identifier, false}};
    rpdo.frame.length = place.length;
    rpdo.meter = FrameMeter(rpdo.frame);
    rpdo.control_word = control_word_at(mapping);
    if (place.exchange == PdoExchange::kOnChange) {
      on_change_[place.node].rpdos.push_back(rpdo);
    } else {
      with_sync_.push_back(rpdo);
      nodes_[place.node].worst_bits += worst_frame_bits(place.length);
    }
  }
  for (auto& group : on_change_) {
    std::stable_partition(group.rpdos.begin(), group.rpdos.end(), [](const Rpdo& rpdo) { return !rpdo.control_word; });
  }
  spread_repetitions();
}

/// In the order of the nodes.
void RpdoOutputs::spread_repetitions() {
  std::int64_t count = 0;
  for (const auto& group : on_change_) count += static_cast<std::int64_t>(group.rpdos.size());
  std::int64_t number = 0;
  for (auto& group : on_change_) {
    for (auto& rpdo : group.rpdos) rpdo.phase = rpdo.place.resend * number++ / count;
  }
}

/// Returns false if the port did not take the frame; rpdo.frame then remains the last frame sent.
bool RpdoOutputs::send_new(CanPort& port, Rpdo& rpdo, std::uint32_t& bits) const noexcept {
  const auto bytes = content(rpdo);
  Frame frame = rpdo.frame;
  copy_few(bytes, frame.data.data());
  if (port.send(frame) != SendStatus::kSent) return false;
  rpdo.frame = frame;
  rpdo.sent = load_few(bytes);
  bits += rpdo.meter.bits(bytes);
  return true;
}

std::uint32_t RpdoOutputs::send_with_sync(CanPort& port, bool synced) noexcept {
  std::uint32_t bits = 0;
  for (auto& group : on_change_) {
    const bool supplied = std::exchange(group.supplied, true);
    group.current = synced && supplied;
  }
  for (auto& rpdo : with_sync_) {
    if (!nodes_[rpdo.place.node].in_use) continue;
    const auto bytes = content(rpdo);
    copy_few(bytes, rpdo.frame.data.data());
    if (port.send(rpdo.frame) == SendStatus::kSent) {
      bits += rpdo.meter.bits(bytes);
      rpdo.outdated = false;
      continue;
    }
    nodes_.note_unsent(rpdo.place.node);
    on_change_[rpdo.place.node].supplied = false;
    ++unsent_;
  }
  return bits;
}

void RpdoOutputs::outdate() noexcept {
  outdated_ = true;
  for (auto& rpdo : with_sync_) {
    rpdo.outdated = true;
    nodes_.note_outdated(rpdo.place.node);
  }
}

bool RpdoOutputs::outdated() noexcept {
  outdated_ = outdated_ && std::any_of(with_sync_.begin(), with_sync_.end(), [this](const Rpdo& rpdo) {
                return rpdo.outdated && nodes_[rpdo.place.node].in_use;
              });
  return outdated_;
}

/// Whether the content of an RPDO on change is to be sent: it is not that of the last frame, or none was sent.
bool RpdoOutputs::changed(const Rpdo& rpdo) const noexcept {
  return rpdo.forced || load_few(content(rpdo)) != rpdo.sent;
}

/// Precondition: the node is in use.
bool RpdoOutputs::due(const Rpdo& rpdo, const Group& group, const Pass& pass) const noexcept {
  if (pass.reason == Reason::kRepetition && pass.now < rpdo.repeat_at) return false;
  const bool changes = changed(rpdo);
  if (changes && !group.current && rpdo.control_word && operates(content(rpdo).subspan(*rpdo.control_word))) {
    return false;
  }
  return changes || pass.reason == Reason::kRepetition;
}

/// Whether none of its RPDOs has changed.
bool RpdoOutputs::rests(const Group& group) const noexcept {
  return std::none_of(group.rpdos.begin(), group.rpdos.end(), [this](const Rpdo& rpdo) { return changed(rpdo); });
}

/// Returns false if an RPDO that is due could not be sent.
bool RpdoOutputs::send_due(std::size_t node, Pass& pass) noexcept {
  auto& group = on_change_[node];
  if (!nodes_[node].in_use || (pass.reason == Reason::kChange && rests(group))) {
    group.waited = false;
    return true;
  }
  bool others_changed = false;
  bool command_waits = false;
  for (auto& rpdo : group.rpdos) {
    if (!due(rpdo, group, pass)) {
      next_repetition_ = std::min(next_repetition_, rpdo.repeat_at);
      continue;
    }
    if (rpdo.control_word && others_changed && !group.waited) {
      command_waits = true;
      continue;
    }
    const auto needed = worst_frame_bits(rpdo.place.length);
    if (!pass.room.fits(needed) || !send_new(pass.port, rpdo, pass.bits)) return false;
    pass.room.use(needed);
    // A node that has come into use gets all of them, and none tells of another.
    others_changed = others_changed || (pass.reason == Reason::kChange && !rpdo.forced);
    rpdo.forced = false;
    rpdo.repeat_at = next_at(rpdo.phase, rpdo.place.resend, pass.now);
    next_repetition_ = std::min(next_repetition_, rpdo.repeat_at);
  }
  if (pass.reason == Reason::kChange) group.waited = command_waits;
  return true;
}

/// A node that has come into use gets all of its RPDOs on change.
void RpdoOutputs::force_begun() noexcept {
  for (std::size_t node = 0; node < on_change_.size(); ++node) {
    if (!nodes_[node].begun) continue;
    for (auto& rpdo : on_change_[node].rpdos) rpdo.forced = true;
  }
}

std::uint32_t RpdoOutputs::send_on_change(CanPort& port, nanoseconds now, PeriodRoom& room) noexcept {
  if (nodes_.some_begun()) force_begun();
  Pass pass{port, now, room, Reason::kChange};
  if (!send_all_due(pass) || now < next_repetition_) return pass.bits;
  pass.reason = Reason::kRepetition;
  next_repetition_ = nanoseconds::max();
  if (!send_all_due(pass)) next_repetition_ = now;
  return pass.bits;
}

/// Returns false if an RPDO that is due could not be sent; the next pass begins with its node.
bool RpdoOutputs::send_all_due(Pass& pass) noexcept {
  for (std::size_t i = 0; i < on_change_.size(); ++i) {
    const auto behind = turn_ + i;
    const auto node = behind < on_change_.size() ? behind : behind - on_change_.size();
    if (send_due(node, pass)) continue;
    turn_ = node;
    return false;
  }
  return true;
}

}  // namespace driveline::canopen
