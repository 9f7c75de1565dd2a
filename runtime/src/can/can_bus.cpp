#include "can/can_bus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "driveline/motion/cycle/cycle_runner.hpp"
#include "driveline/motion/drive/axis_objects.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {
namespace {

/// Cycles by which a CAN line is slower than one of EtherCAT without clocks: an RPDO is sent behind the next SYNC, and
/// acts at the one after that (CiA 301 7.2.2.2).
constexpr double kSyncCycles = 1.0;

double can_setpoint_delay(const LineConfig& config, const motion::AxisConfig& axis) {
  motion::SetpointDelays delays;
  delays.period = config.period;
  delays.interpolation = drive_rules(config, config.slaves[axis.slave]).interpolation_exchanges();
  return kSyncCycles + motion::setpoint_delay_cycles(delays);
}

}  // namespace

CanBus::CanBus(CanSession& session) : session_(session), config_(session.config()) {}

std::vector<motion::Axis> CanBus::make_axes() const {
  std::vector<motion::Axis> axes;
  for (auto axis : config_.axes) {
    axis.on_loss = config_.recovery.axes;
    axis.period = config_.period;
    if (axis.is_virtual()) {
      axes.emplace_back(std::move(axis));
      continue;
    }
    if (!axis.setpoint_delay_cycles) axis.setpoint_delay_cycles = can_setpoint_delay(config_, axis);
    axis.loss_is_certain = true;
    // The loss of an optional node does not stop the others.
    if (config_.slaves[axis.slave].can.optional) axis.on_loss = motion::LossPolicy::kContinue;
    axes.emplace_back(axis, master_->image().place(axis.slave), master_->image().configuration(axis.slave));
  }
  return axes;
}

bool CanBus::lacks_velocity(std::size_t axis) const {
  constexpr std::uint16_t kActualVelocity = 0x606C;
  const auto& config = config_.axes[axis];
  if (config.is_virtual()) return false;
  const auto pdos = motion::pdos_of_drive(master_->image().configuration(config.slave), config.drive);
  return !motion::object_offset(pdos.inputs, kActualVelocity, 32);
}

Result<void> CanBus::start(const CycleParts& parts) {
  canopen::CanCycle::Settings settings;
  settings.copies = process_data_->copies;
  settings.tasks = parts.tasks;
  settings.recorder = &parts.records->recorder();
  settings.trace = parts.trace;
  const auto make_runner = [this](canopen::CanCycle& cycle) -> std::unique_ptr<motion::CycleRunner> {
    if (session_.virtual_time()) return std::make_unique<motion::InlineRunner>(cycle, session_.clock());
    return std::make_unique<motion::RealtimeRunner>(cycle, session_.clock(), config_.realtime, config_.wake_ahead,
                                                    std::chrono::nanoseconds{0});
  };
  const auto started = master_->start_cycle(parts.motion, parts.rings, settings, make_runner);
  if (!started) return fail(ErrorKind::kMachine, started.error().message());
  if (const auto* runner = dynamic_cast<motion::RealtimeRunner*>(master_->runner())) {
    progress(events::RealtimeSetUp{runner->report()});
  }
  const auto operational = master_->go_operational();
  tell_notes();
  if (!operational) return fail_nodes(operational.error());
  state_ = "Operational";
  return {};
}

void CanBus::begin_operation(LineMotion* motion) {
  auto listener = [this](const EventFacts& facts, Severity severity) { tell(facts, severity); };
  watch_ = std::make_unique<CanWatch>(*master_, motion, config_, session_.clock(), std::move(listener));
}

bool CanBus::look() {
  const bool goes_on = watch_->poll();
  tell_notes();
  state_ = watch_->state();
  return goes_on;
}

void CanBus::end_operation() {
  watch_->tell_rest();
  state_ = watch_->state();
}

bool CanBus::answers() noexcept {
  const auto port = master_->port_statistics();
  if (port.down || port.state == canopen::BusState::kBusOff) return false;
  for (std::size_t i = 0; i < config_.slaves.size(); ++i) {
    if (master_->cycle()->node_report(i).valid) return true;
  }
  return false;
}

/// The end of a line without nodes that were lost before is no new failure.
bool CanBus::was_lost(std::size_t node) const {
  if (node >= config_.slaves.size()) return false;
  const auto phase = master_->node(node).phase;
  return phase == canopen::NodePhase::kLost || phase == canopen::NodePhase::kNotSeen ||
         phase == canopen::NodePhase::kFailed;
}

bool CanBus::take_down() {
  if (!master_) return true;
  const auto down = master_->shut_down();
  // No node has received it; the loss of the adapter has been reported.
  if (master_->port_statistics().down) return false;
  bool released = true;
  if (!down) {
    for (const auto& error : down.error()) {
      const bool known = was_lost(error.node) || state_ == "LOST";
      tell(events::NodeNotReleased{error, name_of(error.node)}, known ? Severity::kNotice : Severity::kFailure);
      released = released && known;
    }
  }
  if (released) state_ = "Pre-operational";
  return released;
}

const snapshot::FeedCondition* CanBus::slaves(const std::vector<std::string>& owners, bool now) {
  if (!master_) return nullptr;
  if (!feed_) feed_.emplace(*master_, session_.clock());
  bool changed = feed_->set_owners(owners) || now;
  changed = feed_->poll(now) || changed;
  return changed ? &feed_->condition() : nullptr;
}

void CanBus::tell_notes() {
  for (const auto& note : master_->take_notes()) {
    tell(events::NodeNoted{note, name_of(note.node)}, Severity::kNotice);
  }
}

std::string CanBus::name_of(std::size_t node) const {
  return node < config_.slaves.size() ? config_.slaves[node].name : std::string();
}

/// All nodes fail side by side: each has its sentence.
tl::unexpected<Error> CanBus::fail_nodes(const canopen::NodeErrors& errors) const {
  std::string text;
  bool driven = false;
  for (const auto& error : errors) {
    text += fmt::format("{}{}", text.empty() ? "" : "\n", canopen::describe(error, name_of(error.node)));
    driven = driven || error.kind == canopen::NodeErrorKind::kOtherMaster;
  }
  return fail(driven ? ErrorKind::kLineDriven : ErrorKind::kLine, std::move(text));
}

void CanBus::report(RunReport& report) {
  if (config_.interface) report.interfaces.push_back({*config_.interface, "CAN port", {}});
  auto& cycle = *master_->cycle();
  report.statistics = cycle.statistics();
  if (const auto* runner = master_->runner()) {
    report.thread = runner->usage();
    report.wake_ahead = runner->wake_ahead().value_or(std::chrono::nanoseconds{0});
  }
  report.round_trip_modelled = !config_.interface.has_value();
  if (config_.axes.empty()) report.inputs = read_inputs(process_data_->variables, cycle.image().inputs());
  report.recoveries = master_->recoveries();
  auto& can = report.can.emplace();
  can.bit_rate = config_.can->bit_rate;
  can.planned_load = budget_.load();
  can.worst_load = budget_.worst_load();
  can.port = master_->port_statistics();
  const auto counters = cycle.counters();
  can.late_pdos = counters.stale_frames;
  can.unsent_pdos = counters.rpdos_unsent;
  can.unsent_syncs = counters.syncs_unsent;
  for (std::size_t i = 0; i < config_.slaves.size(); ++i) {
    can.lost_pdos += cycle.node_report(i).lost;
    can.emergencies += master_->node(i).emergencies;
  }
}

}  // namespace driveline::runtime
