#include "driveline/canopen_master/bus_watch.hpp"

#include "driveline/canopen_master/plan_check.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMostBusEvents = 256;  ///< events that are kept until they are taken; older ones are dropped

}  // namespace

BusWatch::BusWatch(const MasterPlan& plan) : sync_identifier_(plan.sync_identifier), master_id_(plan.master_id) {
  for (const auto& node : plan.nodes) {
    known_.set(node.id & kMaxNodeId);
    for (const auto& pdo : node.rpdos) {
      if (const auto identifier = pdo_identifier(pdo, true, node.id); identifier != 0) {
        rpdos_.set(identifier & Identifier::kBaseMask);
      }
    }
  }
}

MasterEvent& BusWatch::tell(MasterEvent::Kind kind, nanoseconds time) {
  if (events_.size() >= kMostBusEvents) events_.pop_front();
  MasterEvent event;
  event.kind = kind;
  event.time = time;
  return events_.emplace_back(event);
}

std::optional<MasterEvent> BusWatch::take_event() {
  if (events_.empty()) return std::nullopt;
  auto event = events_.front();
  events_.pop_front();
  return event;
}

std::optional<OtherMasterSign> BusWatch::sign_of(std::uint32_t identifier) const noexcept {
  if (identifier == predefined::kNmt) return OtherMasterSign::kNmt;
  if (identifier == sync_identifier_) return OtherMasterSign::kSync;
  if (identifier == predefined::kErrorControl + master_id_) return OtherMasterSign::kHeartbeat;
  if (rpdos_.test(identifier & Identifier::kBaseMask)) return OtherMasterSign::kRpdo;
  return std::nullopt;
}

void BusWatch::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (frame.kind != FrameKind::kData || frame.identifier.extended) return;
  look_for_stranger(frame.identifier.value, received.time);
  const auto sign = sign_of(frame.identifier.value);
  if (!sign) return;
  if (!other_) other_ = sign;
  auto& told = told_[static_cast<std::size_t>(*sign)];
  if (told && received.time - *told < kRepeat) return;
  told = received.time;
  tell(MasterEvent::Kind::kOtherMaster, received.time).other = *sign;
}

void BusWatch::look_for_stranger(std::uint32_t identifier, nanoseconds time) {
  const std::uint32_t base = identifier & ~std::uint32_t{kMaxNodeId};
  if (base != predefined::kErrorControl) return;
  const auto id = static_cast<std::uint8_t>(identifier - base);
  if (id == 0 || id == master_id_ || known_.test(id) || strangers_.test(id)) return;
  strangers_.set(id);
  tell(MasterEvent::Kind::kStranger, time).id = id;
}

void BusWatch::look(const PortStatistics& statistics, nanoseconds now) {
  if (statistics.down && !down_) tell(MasterEvent::Kind::kBusDown, now);
  down_ = statistics.down;
  const bool off = statistics.state == BusState::kBusOff;
  const bool was_off = state_ == BusState::kBusOff;
  if (off && !was_off) tell(MasterEvent::Kind::kBusOff, now);
  if (!off && was_off) tell(MasterEvent::Kind::kBusBack, now);
  state_ = statistics.state;
}

}  // namespace driveline::canopen
