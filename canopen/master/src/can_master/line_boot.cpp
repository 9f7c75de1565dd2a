#include "line_boot.hpp"

#include <algorithm>

#include "driveline/canopen_master/bus_budget.hpp"
#include "driveline/canopen_master/plan_check.hpp"

namespace driveline::canopen {
namespace {

constexpr std::chrono::nanoseconds kBootLook = std::chrono::milliseconds{1};  ///< between two looks at the port

/// Time of the longest frame.
std::chrono::nanoseconds longest_frame(std::uint32_t bit_rate) noexcept {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return std::chrono::nanoseconds{std::int64_t{kLongestFrameBits} * kNanoseconds / std::max(bit_rate, 1U)};
}

}  // namespace

NodeError line_error(NodeErrorKind kind) {
  return NodeError{kind};
}

/// Whether another master is on the bus.
bool LineBoot::listen() {
  BusWatch watch(*plan_);
  const auto end = now() + settings_->listen;
  while (now() < end && !watch.other_master()) {
    if (const auto frame = port_->receive()) {
      watch.receive(*frame);
    } else {
      static_cast<void>(port_->wait_readable(end));
      if (port_->statistics().down) return false;
    }
  }
  if (!watch.other_master()) return false;
  auto error = line_error(NodeErrorKind::kOtherMaster);
  error.other = *watch.other_master();
  notes_.push_back(error);
  return true;
}

NodeErrors LineBoot::run(const CanMaster::Progress& progress) {
  if (auto faults = check(*plan_); !faults.empty()) return faults;
  if (listen() && !settings_->force) return std::move(notes_);
  line_ = std::make_unique<NodeLine>(*plan_, SupervisorSettings{settings_->recover, settings_->retry_pause});
  line_->boot(now());
  std::vector<BootStep> told(line_->size(), BootStep::kConfigured);
  while (!line_->all([](const NodeSupervisor& node) { return node.settled(); })) {
    line_->pump(*port_, now());
    tell(progress, told);
    if (port_->statistics().down) return {line_error(NodeErrorKind::kBusDown)};
    static_cast<void>(port_->wait_readable(now() + kBootLook));
    // SDOs have priority over boot-up messages and heartbeats: requests without a pause would hold them back.
    clock_->sleep_until(now() + longest_frame(plan_->bit_rate));
  }
  tell(progress, told);
  adopt_plans();
  if (auto failed = errors(); !failed.empty()) return failed;
  return make_image();
}

void LineBoot::tell(const CanMaster::Progress& progress, std::vector<BootStep>& told) const {
  if (!progress) return;
  for (std::size_t i = 0; i < line_->size(); ++i) {
    if (const auto step = line_->node(i).view().step; told[i] != step) progress(i, told[i] = step);
  }
}

NodeErrors LineBoot::errors() const {
  NodeErrors failed;
  for (std::size_t i = 0; i < line_->size(); ++i) {
    const auto& node = line_->node(i);
    if (node.view().error) failed.push_back(*node.view().error);
  }
  return failed;
}

void LineBoot::adopt_plans() {
  for (std::size_t i = 0; i < line_->size(); ++i) {
    plan_->nodes[i] = line_->node(i).plan();
    for (auto& note : line_->node(i).take_notes()) notes_.push_back(note);
    const auto& control = plan_->nodes[i].error_control;
    if (control.heartbeat.count() > 0 || control.guard_time.count() > 0) continue;
    notes_.push_back({NodeErrorKind::kUnwatched, i, plan_->nodes[i].id, BootStep::kErrorControl});
  }
}

/// Returns an error for a PDO whose mapping is unknown, because its node is optional and missing.
std::optional<NodeError> LineBoot::missing_mapping(std::size_t number) const {
  const auto& node = plan_->nodes[number];
  for (const bool rpdo : {true, false}) {
    const auto& pdos = rpdo ? node.rpdos : node.tpdos;
    const auto unknown = std::find_if(pdos.begin(), pdos.end(), [](const PdoPlan& pdo) { return pdo.objects.empty(); });
    if (unknown == pdos.end()) continue;
    NodeError error{NodeErrorKind::kEmptyMapping, number, node.id, BootStep::kPdos};
    error.pdo = unknown->number;
    error.rpdo = rpdo;
    return error;
  }
  return std::nullopt;
}

NodeErrors LineBoot::make_image() {
  NodeErrors unknown;
  for (std::size_t i = 0; i < plan_->nodes.size(); ++i) {
    if (const auto error = missing_mapping(i)) unknown.push_back(*error);
  }
  if (!unknown.empty()) return unknown;
  auto image = PdoImage::build(*plan_);
  if (image) {
    image_ = std::move(*image);
    return {};
  }
  // check() finds everything but what it cannot know before the boot.
  NodeError error{NodeErrorKind::kBadPlan, image.error().node, plan_->nodes[image.error().node].id, BootStep::kPdos};
  error.fault = PlanFault::kPdoIdentifier;
  error.pdo = image.error().pdo;
  error.rpdo = image.error().output;
  error.found = image.error().identifier;
  return {error};
}

}  // namespace driveline::canopen
