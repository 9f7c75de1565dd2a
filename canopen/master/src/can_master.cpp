#include "driveline/canopen_master/can_master.hpp"

#include <algorithm>
#include <deque>

#include "driveline/canopen_master/acyclic_port.hpp"
#include "driveline/canopen_master/node_line.hpp"
#include "driveline/canopen_master/plan_check.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kLook = milliseconds{1};       ///< between two looks at the port while a boot waits
constexpr nanoseconds kIdleSlice = milliseconds{5};  ///< between two looks at nodes that run
constexpr nanoseconds kBusySlice = milliseconds{2};  ///< while nodes are booted
constexpr nanoseconds kReleaseTime = milliseconds{5000};
constexpr std::size_t kMostMasterEvents = 1024;  ///< that nobody takes; older ones are dropped
constexpr int kLastCycles = 4;                   ///< in which the last frames leave

NodeError line_error(NodeErrorKind kind) {
  NodeError error{kind};
  error.id = 0;
  return error;
}

}  // namespace

/// What the facade is made of.
class CanMaster::Parts {
 public:
  Parts(CanPort& port, rt::Clock& clock, MasterPlan plan, const Settings& settings)
      : port_(&port), clock_(&clock), plan_(std::move(plan)), settings_(settings) {}

  [[nodiscard]] CanPort& bus() noexcept { return cycling_ ? static_cast<CanPort&>(*acyclic_) : *port_; }
  [[nodiscard]] nanoseconds now() const noexcept { return clock_->now(); }
  [[nodiscard]] bool listen();
  [[nodiscard]] NodeErrors boot(const Progress& progress);
  void tell_progress(const Progress& progress, std::vector<BootStep>& told) const;
  [[nodiscard]] NodeErrors boot_errors() const;
  void adopt_plans();
  [[nodiscard]] NodeErrors make_image();
  [[nodiscard]] std::optional<NodeError> missing_mapping(std::size_t number) const;
  void wait(nanoseconds duration);
  void supervise();
  [[nodiscard]] NodeErrors start_errors() const;
  [[nodiscard]] NodeErrors await_pdos();
  [[nodiscard]] ClientResult<std::vector<std::byte>> request(std::size_t node, SdoObject object,
                                                             std::optional<std::vector<std::byte>> data);
  void release();

  CanPort* port_;
  rt::Clock* clock_;
  MasterPlan plan_;
  Settings settings_;
  std::unique_ptr<NodeLine> line_;
  std::optional<PdoImage> image_;
  std::unique_ptr<AcyclicChannel> channel_;
  std::optional<AcyclicPort> acyclic_;
  std::unique_ptr<CanCycle> cycle_;
  std::unique_ptr<motion::CycleRunner> runner_;
  std::deque<MasterEvent> events_;
  NodeErrors notes_;
  bool cycling_ = false;
};

/// Whether another master is on the bus.
bool CanMaster::Parts::listen() {
  BusWatch watch(plan_);
  const auto end = now() + settings_.listen;
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

NodeErrors CanMaster::Parts::boot(const Progress& progress) {
  if (auto faults = check(plan_); !faults.empty()) return faults;
  if (listen() && !settings_.force) return std::exchange(notes_, {});
  line_ = std::make_unique<NodeLine>(plan_, SupervisorSettings{settings_.recover, settings_.retry_pause});
  line_->boot(now());
  std::vector<BootStep> told(line_->size(), BootStep::kConfigured);
  while (!line_->all([](const NodeSupervisor& node) { return node.settled(); })) {
    line_->pump(*port_, now());
    tell_progress(progress, told);
    if (port_->statistics().down) return {line_error(NodeErrorKind::kBusDown)};
    static_cast<void>(port_->wait_readable(now() + kLook));
  }
  tell_progress(progress, told);
  adopt_plans();
  if (auto errors = boot_errors(); !errors.empty()) return errors;
  return make_image();
}

void CanMaster::Parts::tell_progress(const Progress& progress, std::vector<BootStep>& told) const {
  if (!progress) return;
  for (std::size_t i = 0; i < line_->size(); ++i) {
    if (const auto step = line_->node(i).view().step; told[i] != step) progress(i, told[i] = step);
  }
}

NodeErrors CanMaster::Parts::boot_errors() const {
  NodeErrors errors;
  for (std::size_t i = 0; i < line_->size(); ++i) {
    const auto& node = line_->node(i);
    if (node.view().error) errors.push_back(*node.view().error);
  }
  return errors;
}

void CanMaster::Parts::adopt_plans() {
  for (std::size_t i = 0; i < line_->size(); ++i) {
    plan_.nodes[i] = line_->node(i).plan();
    for (auto& note : line_->node(i).take_notes()) notes_.push_back(note);
  }
}

/// A PDO whose mapping nobody knows, because its node is optional and missing.
std::optional<NodeError> CanMaster::Parts::missing_mapping(std::size_t number) const {
  const auto& node = plan_.nodes[number];
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

NodeErrors CanMaster::Parts::make_image() {
  NodeErrors errors;
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i) {
    if (const auto error = missing_mapping(i)) errors.push_back(*error);
  }
  if (!errors.empty()) return errors;
  auto image = PdoImage::build(plan_);
  if (image) {
    image_ = std::move(*image);
    return {};
  }
  // check() finds everything but what it cannot know before the boot.
  NodeError error{NodeErrorKind::kBadPlan, image.error().node, plan_.nodes[image.error().node].id, BootStep::kPdos};
  error.fault = PlanFault::kPdoIdentifier;
  error.pdo = image.error().pdo;
  error.rpdo = image.error().output;
  error.found = image.error().identifier;
  return {error};
}

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

CanMaster::CanMaster(CanPort& port, rt::Clock& clock, MasterPlan plan, const Settings& settings)
    : parts_(std::make_unique<Parts>(port, clock, std::move(plan), settings)) {}

CanMaster::~CanMaster() {
  if (parts_->runner_) parts_->runner_->stop();
}

MasterResult<void> CanMaster::boot(const Progress& progress) {
  if (auto errors = parts_->boot(progress); !errors.empty()) return tl::unexpected(std::move(errors));
  return {};
}

NodeErrors CanMaster::take_notes() {
  return std::exchange(parts_->notes_, {});
}

const MasterPlan& CanMaster::plan() const noexcept {
  return parts_->plan_;
}

const PdoImage& CanMaster::image() const noexcept {
  return parts_->cycle_ ? parts_->cycle_->image() : *parts_->image_;
}

tl::expected<void, rt::RealtimeError> CanMaster::start_cycle(motion::MotionControl* motion, motion::SampleRings rings,
                                                             const CanCycle::Settings& settings,
                                                             const MakeRunner& make_runner) {
  auto& parts = *parts_;
  parts.channel_ = std::make_unique<AcyclicChannel>();
  parts.cycle_ = std::make_unique<CanCycle>(*parts.port_, *parts.clock_, parts.plan_, *parts.image_, *parts.channel_,
                                            motion, rings, settings);
  parts.runner_ = make_runner(*parts.cycle_);
  if (auto started = parts.runner_->start(); !started) return started;
  parts.acyclic_.emplace(*parts.channel_, *parts.clock_, parts.plan_.period,
                         [runner = parts.runner_.get()](nanoseconds duration) { runner->pass(duration); });
  parts.cycling_ = true;
  parts.line_->watch(parts.now());
  return {};
}

MasterResult<void> CanMaster::go_operational() {
  auto& parts = *parts_;
  // Drives see SYNC, and the heartbeat of the master, before they are started.
  parts.wait(parts.plan_.period);
  parts.supervise();
  parts.line_->start(parts.now());
  const auto there = [](const NodeSupervisor& node) { return node.operational() || node.excused(); };
  while (!parts.line_->all(there)) {
    parts.supervise();
    if (auto errors = parts.start_errors(); !errors.empty()) return tl::unexpected(std::move(errors));
    if (parts.bus().statistics().down) return tl::unexpected(NodeErrors{line_error(NodeErrorKind::kBusDown)});
    parts.wait(parts.plan_.period);
  }
  parts.supervise();
  if (auto errors = parts.await_pdos(); !errors.empty()) return tl::unexpected(std::move(errors));
  return {};
}

void CanMaster::pass(nanoseconds duration) {
  const auto end = parts_->now() + duration;
  for (auto now = parts_->now(); now < end; now = parts_->now()) {
    const bool busy = !parts_->line_->all([](const NodeSupervisor& node) { return node.operational(); });
    parts_->wait(std::min(end - now, busy ? kBusySlice : kIdleSlice));
    parts_->supervise();
  }
}

void CanMaster::supervise() {
  parts_->supervise();
}

std::optional<MasterEvent> CanMaster::take_event() {
  auto& events = parts_->events_;
  if (events.empty()) return std::nullopt;
  auto event = events.front();
  events.pop_front();
  return event;
}

const NodeView& CanMaster::node(std::size_t node) const noexcept {
  static const NodeView kNothing;
  return parts_->line_ ? parts_->line_->node(node).view() : kNothing;
}

bool CanMaster::all_operational() const noexcept {
  return parts_->line_ &&
         parts_->line_->all([](const NodeSupervisor& node) { return node.operational() || node.excused(); });
}

std::uint64_t CanMaster::recoveries() const noexcept {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; parts_->line_ && i < parts_->line_->size(); ++i) {
    sum += parts_->line_->node(i).view().recoveries;
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
  return parts_->cycle_.get();
}

motion::CycleRunner* CanMaster::runner() noexcept {
  return parts_->runner_.get();
}

bool CanMaster::cycling() const noexcept {
  return parts_->cycling_;
}

MasterResult<void> CanMaster::shut_down() {
  auto& parts = *parts_;
  if (!parts.line_) return {};
  parts.release();
  if (parts.runner_) parts.runner_->stop();
  parts.cycling_ = false;
  NodeErrors errors;
  for (std::size_t i = 0; i < parts.line_->size(); ++i) {
    if (const auto& error = parts.line_->node(i).release_error()) errors.push_back(*error);
  }
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  return {};
}

}  // namespace driveline::canopen
