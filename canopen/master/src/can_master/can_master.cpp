#include "driveline/canopen_master/can_master.hpp"

#include <algorithm>

#include "line_boot.hpp"
#include "parts.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kIdleSlice = milliseconds{5};  ///< between two looks at nodes that run
constexpr nanoseconds kBusySlice = milliseconds{2};  ///< while nodes are booted

}  // namespace

CanMaster::CanMaster(CanPort& port, rt::Clock& clock, MasterPlan plan, const Settings& settings)
    : parts_(std::make_unique<Parts>(port, clock, std::move(plan), settings)) {}

CanMaster::~CanMaster() {
  if (parts_->runner) parts_->runner->stop();
}

MasterResult<void> CanMaster::boot(const Progress& progress) {
  auto& parts = *parts_;
  LineBoot boot(*parts.port, *parts.clock, parts.plan, parts.settings);
  auto errors = boot.run(progress);
  parts.line = boot.take_line();
  parts.image = boot.take_image();
  parts.notes = boot.take_notes();
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  return {};
}

NodeErrors CanMaster::take_notes() {
  return std::exchange(parts_->notes, {});
}

const MasterPlan& CanMaster::plan() const noexcept {
  return parts_->plan;
}

const PdoImage& CanMaster::image() const noexcept {
  return parts_->cycle ? parts_->cycle->image() : *parts_->image;
}

tl::expected<void, rt::RealtimeError> CanMaster::start_cycle(motion::MotionControl* motion, motion::SampleRings rings,
                                                             const CanCycle::Settings& settings,
                                                             const MakeRunner& make_runner) {
  auto& parts = *parts_;
  parts.channel = std::make_unique<AcyclicChannel>();
  parts.cycle = std::make_unique<CanCycle>(*parts.port, *parts.clock, parts.plan, *parts.image, *parts.channel, motion,
                                           rings, settings);
  parts.runner = make_runner(*parts.cycle);
  if (auto started = parts.runner->start(); !started) return started;
  parts.acyclic.emplace(*parts.channel, *parts.clock, parts.plan.period,
                        [runner = parts.runner.get()](nanoseconds duration) { runner->pass(duration); });
  parts.cycling = true;
  parts.line->watch(parts.now());
  return {};
}

MasterResult<void> CanMaster::go_operational() {
  auto& parts = *parts_;
  // Drives see SYNC, and the heartbeat of the master, before they are started.
  parts.wait(parts.plan.period);
  parts.supervise();
  parts.line->start(parts.now());
  const auto there = [](const NodeSupervisor& node) { return node.operational() || node.excused(); };
  while (!parts.line->all(there)) {
    parts.supervise();
    if (auto errors = parts.start_errors(); !errors.empty()) return tl::unexpected(std::move(errors));
    if (parts.bus().statistics().down) return tl::unexpected(NodeErrors{line_error(NodeErrorKind::kBusDown)});
    parts.wait(parts.plan.period);
  }
  parts.supervise();
  if (auto errors = parts.await_pdos(); !errors.empty()) return tl::unexpected(std::move(errors));
  return {};
}

void CanMaster::pass(nanoseconds duration) {
  const auto end = parts_->now() + duration;
  for (auto now = parts_->now(); now < end; now = parts_->now()) {
    const bool busy = !parts_->line->all([](const NodeSupervisor& node) { return node.operational(); });
    parts_->wait(std::min(end - now, busy ? kBusySlice : kIdleSlice));
    parts_->supervise();
  }
}

void CanMaster::supervise() {
  parts_->supervise();
}

std::optional<MasterEvent> CanMaster::take_event() {
  auto& events = parts_->events;
  if (events.empty()) return std::nullopt;
  auto event = events.front();
  events.pop_front();
  return event;
}

const NodeView& CanMaster::node(std::size_t node) const noexcept {
  static const NodeView kNothing;
  return parts_->line ? parts_->line->node(node).view() : kNothing;
}

bool CanMaster::all_operational() const noexcept {
  return parts_->line &&
         parts_->line->all([](const NodeSupervisor& node) { return node.operational() || node.excused(); });
}

std::uint64_t CanMaster::recoveries() const noexcept {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; parts_->line && i < parts_->line->size(); ++i) {
    sum += parts_->line->node(i).view().recoveries;
  }
  return sum;
}

PortStatistics CanMaster::port_statistics() const noexcept {
  return parts_->bus().statistics();
}

ClientResult<std::vector<std::byte>> CanMaster::upload(std::size_t node, SdoObject object) {
  return parts_->request(node, object, std::nullopt);
}

ClientResult<void> CanMaster::download(std::size_t node, SdoObject object, std::span<const std::byte> data) {
  const auto done = parts_->request(node, object, std::vector<std::byte>(data.begin(), data.end()));
  if (!done) return tl::unexpected(done.error());
  return {};
}

CanCycle* CanMaster::cycle() noexcept {
  return parts_->cycle.get();
}

motion::CycleRunner* CanMaster::runner() noexcept {
  return parts_->runner.get();
}

bool CanMaster::cycling() const noexcept {
  return parts_->cycling;
}

MasterResult<void> CanMaster::shut_down() {
  auto& parts = *parts_;
  if (!parts.line) return {};
  parts.release();
  if (parts.runner) parts.runner->stop();
  parts.cycling = false;
  NodeErrors errors;
  for (std::size_t i = 0; i < parts.line->size(); ++i) {
    if (const auto& error = parts.line->node(i).release_error()) errors.push_back(*error);
  }
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  return {};
}

}  // namespace driveline::canopen
