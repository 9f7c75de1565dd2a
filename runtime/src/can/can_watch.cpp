#include "can/can_watch.hpp"

#include <utility>
#include <vector>

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {
namespace {

using canopen::BusState;
using canopen::MasterEvent;
using motion::LossPolicy;

std::vector<LossWatch::Losable> losable_nodes(const canopen::CanMaster& master) {
  std::vector<LossWatch::Losable> nodes;
  for (const auto& node : master.plan().nodes) nodes.push_back({node.optional});
  return nodes;
}

/// Error passive and bus off are worth a word; the counters move below that all the time.
bool is_bad(BusState state) noexcept {
  return state == BusState::kErrorPassive || state == BusState::kBusOff;
}

}  // namespace

CanWatch::CanWatch(canopen::CanMaster& master, LineMotion* motion, const LineConfig& config, rt::Clock& clock,
                   Listener listener)
    : master_(master),
      motion_(motion),
      config_(config),
      listener_(std::move(listener)),
      losses_({&config, &clock, motion,
               [&cycle = *master.cycle()](motion::MasterAbsence& absence) { return cycle.take_absence(absence); }},
              losable_nodes(master), listener_),
      adapter_(master.port_statistics().state) {}

bool CanWatch::poll() {
  if (!losses_.master_was_there()) return false;
  master_.supervise();
  const bool line = take_events();
  look_at_adapter();
  if (motion_ != nullptr) motion_->poll(listener_);
  const bool motion = losses_.motion_goes_on();
  return line && motion && !waits_in_vain();
}

bool CanWatch::take_events() {
  bool goes_on = true;
  while (const auto event = master_.take_event()) goes_on = take(*event) && goes_on;
  return goes_on;
}

events::NodeChanged CanWatch::changed(const MasterEvent& event) const {
  return {event, event.id == 0 ? std::string() : name_of(event.node), std::nullopt};
}

bool CanWatch::take(const MasterEvent& event) {
  switch (event.kind) {
    case MasterEvent::Kind::kNodeLost:
    case MasterEvent::Kind::kNodeRebooted:
    case MasterEvent::Kind::kWrongState:
      return take_loss(event);
    case MasterEvent::Kind::kBusOff:
      return take_bus_off(event);
    case MasterEvent::Kind::kBusDown:
      state_ = "LOST";
      tell(changed(event), Severity::kFailure);
      return false;
    case MasterEvent::Kind::kNodeBack:
    case MasterEvent::Kind::kNodeJoined:
      losses_.back(event.node);
      tell(changed(event), Severity::kNotice);
      return true;
    case MasterEvent::Kind::kRecoveryFailed:
    case MasterEvent::Kind::kDoubleAnswers:
    case MasterEvent::Kind::kOtherMaster:
      tell(changed(event), Severity::kFault);
      return true;
    case MasterEvent::Kind::kStranger:
      tell(events::NodeChanged{event, {}, std::nullopt}, Severity::kNotice);
      return true;
    case MasterEvent::Kind::kEmergency:
    case MasterEvent::Kind::kErrorReset:
    case MasterEvent::Kind::kNote:
    case MasterEvent::Kind::kGuardToggle:
    case MasterEvent::Kind::kBusBack:
      tell(changed(event), Severity::kNotice);
      return true;
  }
  return true;
}

bool CanWatch::take_loss(const MasterEvent& event) {
  losses_.lost(event.node, event.time);
  auto facts = changed(event);
  facts.after = losses_.cause_of(event.time);
  if (losses_.expendable(event.node)) {
    tell(std::move(facts), Severity::kFault);
    return true;
  }
  state_ = "INCOMPLETE";
  tell(std::move(facts), Severity::kFailure);
  return false;
}

bool CanWatch::take_bus_off(const MasterEvent& event) {
  const bool over = config_.recovery.axes == LossPolicy::kStop;
  if (over) state_ = "LOST";
  tell(changed(event), over ? Severity::kFailure : Severity::kFault);
  return !over;
}

/// Bus off is told by the master.
void CanWatch::look_at_adapter() {
  const auto port = master_.port_statistics();
  const auto before = std::exchange(adapter_, port.state);
  if (port.state == before || port.state == BusState::kBusOff || before == BusState::kBusOff) return;
  if (!is_bad(port.state) && !is_bad(before)) return;
  tell(events::CanStateChanged{port.state, port.send_errors, port.receive_errors}, Severity::kNotice);
}

bool CanWatch::waits_in_vain() {
  const auto missed = losses_.missed_too_long();
  if (!missed) return false;
  state_ = "INCOMPLETE";
  tell(events::SlaveNotBack{*missed, name_of(*missed), config_.recovery.give_up}, Severity::kFailure);
  return true;
}

void CanWatch::tell_rest() {
  if (motion_ != nullptr) motion_->poll(listener_);
  losses_.tell_rest(master_.cycle()->absences_dropped());
  const auto missed = losses_.first_missed();
  if (!missed || state_ != "Operational") return;
  state_ = "INCOMPLETE";
  tell(events::SlaveNotBack{*missed, name_of(*missed), std::nullopt}, Severity::kFailure);
}

}  // namespace driveline::runtime
