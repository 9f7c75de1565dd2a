#include "parts.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kLook = milliseconds{1};  ///< between two looks at the port while no cycle runs
constexpr nanoseconds kReleaseTime = std::chrono::seconds{5};
constexpr std::size_t kMostMasterEvents = 1024;  ///< events that are kept until they are taken; older ones are dropped
constexpr int kLastCycles = 4;                   ///< cycles in which the last frames leave

}  // namespace

void CanMaster::Parts::wait(nanoseconds duration) {
  if (cycling) {
    runner->pass(duration);
  } else {
    static_cast<void>(port->wait_readable(now() + duration));
  }
}

/// The newest short TPDO of a node; none: there was none.
std::optional<NodeError> CanMaster::Parts::short_pdo(std::size_t node) const {
  const auto report = cycle->node_report(node);
  if (report.short_pdo == 0) return std::nullopt;
  NodeError error{NodeErrorKind::kShortPdo, node, plan.nodes[node].id, BootStep::kStart};
  error.pdo = report.short_pdo;
  error.wanted = report.mapped_bytes;
  error.found = report.short_bytes;
  return error;
}

void CanMaster::Parts::tell_short_pdos() {
  short_told.resize(line->size());
  for (std::size_t i = 0; i < line->size(); ++i) {
    if (short_told[i]) continue;
    if (const auto error = short_pdo(i)) {
      short_told[i] = true;
      tell_note(*error);
    }
  }
}

void CanMaster::Parts::tell_note(const NodeError& note) {
  MasterEvent event;
  event.kind = MasterEvent::Kind::kNote;
  event.node = note.node;
  event.id = note.id;
  event.time = now();
  event.error = note;
  events.push_back(event);
}

void CanMaster::Parts::supervise() {
  if (!line) return;
  line->pump(bus(), now());
  for (std::size_t i = 0; i < line->size(); ++i) {
    auto& node = line->node(i);
    if (cycle) cycle->set_operational(i, node.operational());
    for (const auto& note : node.take_notes()) tell_note(note);
  }
  if (cycle) tell_short_pdos();
  for (auto& event : line->take_events()) events.push_back(event);
  while (events.size() > kMostMasterEvents) events.pop_front();
}

NodeErrors CanMaster::Parts::start_errors() const {
  NodeErrors errors;
  for (std::size_t i = 0; i < line->size(); ++i) {
    const auto& view = line->node(i).view();
    if (view.phase == NodePhase::kFailed && view.error) errors.push_back(*view.error);
    if (view.phase != NodePhase::kLost) continue;
    errors.push_back({NodeErrorKind::kAbsent, i, line->node(i).plan().id, BootStep::kStart});
  }
  return errors;
}

NodeErrors CanMaster::Parts::await_pdos() {
  const auto report_of = [this](std::size_t i) { return cycle->node_report(i); };
  const auto holds = [&](auto member) {
    for (std::size_t i = 0; i < line->size(); ++i) {
      if (line->node(i).operational() && !(report_of(i).*member)) return false;
    }
    return true;
  };
  const auto end = now() + settings.first_pdos;
  while (now() < end && !(holds(&NodeReport::valid) && holds(&NodeReport::heard))) {
    wait(plan.period);
    supervise();
    if (auto errors = start_errors(); !errors.empty()) return errors;
  }
  NodeErrors errors;
  for (std::size_t i = 0; i < line->size(); ++i) {
    if (!line->node(i).operational()) continue;
    const auto report = report_of(i);
    if (report.valid && report.heard) continue;
    if (const auto error = report.valid ? std::nullopt : short_pdo(i)) {
      errors.push_back(*error);
      continue;
    }
    NodeError error{NodeErrorKind::kNoPdo, i, plan.nodes[i].id, BootStep::kStart};
    error.waited_ms = static_cast<std::uint32_t>(settings.first_pdos.count() / 1'000'000);
    // A node may have nothing to tell in a PDO that is sent on change.
    (report.valid ? notes : errors).push_back(error);
  }
  return errors;
}

ClientResult<std::vector<std::byte>> CanMaster::Parts::request(std::size_t node, SdoObject object,
                                                               std::optional<std::vector<std::byte>> data) {
  if (!line) return tl::unexpected(ClientError{ClientErrorKind::kStopped, plan.nodes[node].id, object});
  struct Answer {
    bool done = false;
    ClientResult<std::vector<std::byte>> result;
  };
  const auto answer = std::make_shared<Answer>();
  line->node(node).sdo().ask(object, std::move(data), [answer](auto& result) {
    answer->done = true;
    answer->result = std::move(result);
  });
  supervise();
  while (!answer->done) {
    wait(cycling ? plan.period : kLook);
    supervise();
    if (bus().statistics().down && !answer->done) {
      line->node(node).sdo().fail({ClientErrorKind::kDown});
      if (!answer->done) return tl::unexpected(ClientError{ClientErrorKind::kDown, plan.nodes[node].id, object});
    }
  }
  return std::move(answer->result);
}

void CanMaster::Parts::release() {
  if (cycle) {
    for (std::size_t i = 0; i < line->size(); ++i) cycle->set_operational(i, false);
  }
  line->release(now());
  const auto end = now() + kReleaseTime;
  const auto released = [](const NodeSupervisor& node) { return node.released(); };
  while (now() < end && !line->all(released) && !bus().statistics().down) {
    supervise();
    wait(cycling ? plan.period : kLook);
  }
  for (int i = 0; i < kLastCycles && cycling; ++i) wait(plan.period);
}

}  // namespace driveline::canopen
