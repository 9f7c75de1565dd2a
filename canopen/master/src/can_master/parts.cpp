#include "parts.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kLook = milliseconds{1};  ///< between two looks at the port while no cycle runs
constexpr nanoseconds kReleaseTime = std::chrono::seconds{5};
constexpr std::size_t kMostMasterEvents = 1024;  ///< that nobody takes; older ones are dropped
constexpr int kLastCycles = 4;                   ///< in which the last frames leave

}  // namespace

void CanMaster::Parts::wait(nanoseconds duration) {
  if (cycling_) {
    runner_->pass(duration);
  } else {
    static_cast<void>(port_->wait_readable(now() + duration));
  }
}

void CanMaster::Parts::supervise() {
  if (!line_) return;
  line_->pump(bus(), now());
  for (std::size_t i = 0; i < line_->size(); ++i) {
    auto& node = line_->node(i);
    if (cycle_) cycle_->set_operational(i, node.operational());
    for (auto& note : node.take_notes()) {
      MasterEvent event;
      event.kind = MasterEvent::Kind::kNote;
      event.node = i;
      event.id = node.plan().id;
      event.time = now();
      event.error = note;
      events_.push_back(event);
    }
  }
  for (auto& event : line_->take_events()) events_.push_back(event);
  while (events_.size() > kMostMasterEvents) events_.pop_front();
}

NodeErrors CanMaster::Parts::start_errors() const {
  NodeErrors errors;
  for (std::size_t i = 0; i < line_->size(); ++i) {
    const auto& view = line_->node(i).view();
    if (view.phase == NodePhase::kFailed && view.error) errors.push_back(*view.error);
    if (view.phase != NodePhase::kLost) continue;
    errors.push_back({NodeErrorKind::kAbsent, i, line_->node(i).plan().id, BootStep::kStart});
  }
  return errors;
}

NodeErrors CanMaster::Parts::await_pdos() {
  const auto report_of = [this](std::size_t i) { return cycle_->node_report(i); };
  const auto holds = [&](auto member) {
    for (std::size_t i = 0; i < line_->size(); ++i) {
      if (line_->node(i).operational() && !(report_of(i).*member)) return false;
    }
    return true;
  };
  const auto end = now() + settings_.first_pdos;
  while (now() < end && !(holds(&NodeReport::valid) && holds(&NodeReport::heard))) {
    wait(plan_.period);
    supervise();
    if (auto errors = start_errors(); !errors.empty()) return errors;
  }
  NodeErrors errors;
  for (std::size_t i = 0; i < line_->size(); ++i) {
    if (!line_->node(i).operational()) continue;
    const auto report = report_of(i);
    if (report.valid && report.heard) continue;
    NodeError error{NodeErrorKind::kNoPdo, i, plan_.nodes[i].id, BootStep::kStart};
    error.waited_ms = static_cast<std::uint32_t>(settings_.first_pdos.count() / 1'000'000);
    // A node may have nothing to tell in a PDO that is sent on change.
    (report.valid ? notes_ : errors).push_back(error);
  }
  return errors;
}

ClientResult<std::vector<std::byte>> CanMaster::Parts::request(std::size_t node, SdoObject object,
                                                               std::optional<std::vector<std::byte>> data) {
  if (!line_) return tl::unexpected(ClientError{ClientErrorKind::kStopped, plan_.nodes[node].id, object});
  struct Answer {
    bool done = false;
    ClientResult<std::vector<std::byte>> result;
  };
  const auto answer = std::make_shared<Answer>();
  line_->node(node).sdo().ask(object, std::move(data), [answer](auto& result) {
    answer->done = true;
    answer->result = std::move(result);
  });
  supervise();
  while (!answer->done) {
    wait(cycling_ ? plan_.period : kLook);
    supervise();
    if (bus().statistics().down && !answer->done) {
      line_->node(node).sdo().fail({ClientErrorKind::kDown});
      if (!answer->done) return tl::unexpected(ClientError{ClientErrorKind::kDown, plan_.nodes[node].id, object});
    }
  }
  return std::move(answer->result);
}

void CanMaster::Parts::release() {
  if (cycle_) {
    for (std::size_t i = 0; i < line_->size(); ++i) cycle_->set_operational(i, false);
  }
  line_->release(now());
  const auto end = now() + kReleaseTime;
  const auto released = [](const NodeSupervisor& node) { return node.released(); };
  while (now() < end && !line_->all(released) && !bus().statistics().down) {
    supervise();
    wait(cycling_ ? plan_.period : kLook);
  }
  for (int i = 0; i < kLastCycles && cycling_; ++i) wait(plan_.period);
}

}  // namespace driveline::canopen
