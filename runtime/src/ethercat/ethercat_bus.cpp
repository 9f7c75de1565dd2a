#include "ethercat/ethercat_bus.hpp"

#include "driveline/motion/cycle/cycle_runner.hpp"
#include "driveline/runtime/ethercat/configure_line.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/setup/clock_text.hpp"
#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {

EtherCatBus::EtherCatBus(Session& session)
    : session_(session),
      config_(session.config()),
      master_(session.port(), session.clock(), master_settings(config_)),
      services_(config_),
      group_watch_(config_.process_data) {}

std::vector<motion::Axis> EtherCatBus::make_axes() const {
  return runtime::make_axes(config_, master_);
}

std::chrono::nanoseconds EtherCatBus::input_age(std::size_t slave) const {
  return runtime::input_age(slave, master_);
}

Result<void> EtherCatBus::start(const CycleParts& parts) {
  auto settings = cycle_settings(config_, master_);
  settings.copies = process_data_->copies;
  settings.tasks = parts.tasks;
  settings.recorder = &parts.records->recorder();
  settings.trace = parts.trace;
  const auto make_runner = [this](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
    if (session_.virtual_time()) return std::make_unique<motion::InlineRunner>(core, session_.clock());
    return std::make_unique<motion::RealtimeRunner>(core, session_.clock(), config_.realtime, config_.wake_ahead,
                                                    session_.launch_ahead());
  };
  const auto started = master_.start_cycle(parts.motion, parts.rings, settings, make_runner);
  if (!started) return fail(ErrorKind::kMachine, started.error().message());
  if (const auto* runner = dynamic_cast<motion::RealtimeRunner*>(master_.runner())) {
    progress(events::RealtimeSetUp{runner->report()});
  }
  const auto operational = master_.go_operational();
  tell_startup_notes();
  if (!operational) {
    return tl::unexpected(Error{ErrorKind::kLine,
                                startup_idn_place(operational.error(), master_.slaves()),
                                with_clock_remedy(operational.error()),
                                {},
                                0,
                                operational.error()});
  }
  if (auto* watch = master_.clock_watch()) {
    progress(events::ClocksLocked{watch->clocks().reference, master_.clock_follower()->status().ppm});
  }
  state_ = "OP";
  return {};
}

Result<void> EtherCatBus::start_services() {
  if (auto offered = services_.start(master_); !offered) return offered;
  for (auto& offer : services_.offers()) progress(std::move(offer));
  return {};
}

void EtherCatBus::begin_operation(LineMotion* motion) {
  if (auto* watch = master_.clock_watch()) watch->restart_statistics();
  auto listener = [this](const EventFacts& facts, Severity severity) { tell(with_link(facts), severity); };
  watch_ =
      std::make_unique<LineWatch>(master_, session_.ring(), motion, config_, session_.clock(), std::move(listener));
}

bool EtherCatBus::look() {
  for (auto& change : group_watch_.poll(*master_.core())) progress(std::move(change));
  tell_services();
  tell_startup_notes();
  const bool goes_on = watch_->poll();
  state_ = watch_->state();
  return goes_on;
}

void EtherCatBus::end_operation() {
  watch_->tell_rest();
  state_ = watch_->state();
}

void EtherCatBus::stop_services() {
  services_.stop();
  tell_services();
  tell_traffic();
}

bool EtherCatBus::take_down() {
  const auto down = master_.shut_down();
  if (!down) {
    tell(events::NotInInit{down.error()}, Severity::kFailure);
    return false;
  }
  state_ = "INIT";
  return true;
}

const snapshot::FeedCondition* EtherCatBus::slaves(const std::vector<std::string>& owners, bool now) {
  if (!configured_) return nullptr;
  if (!slave_watch_) slave_watch_.emplace(master_, session_.clock());
  bool changed = slave_watch_->set_owners(owners) || now;
  if (now) {
    slave_watch_->read();
  } else {
    changed = slave_watch_->poll() || changed;
  }
  return changed ? &slave_watch_->condition() : nullptr;
}

ecat_master::Result<ecat_master::LineDiagnosis> EtherCatBus::diagnose() {
  auto diagnosis = ecat_master::diagnose(master_, &watch_->supervisor(), session_.ring());
  if (diagnosis) diagnosis->round_trip_modelled = !config_.interface.has_value();
  return diagnosis;
}

/// Tells what slaves refused that were configured since the last call.
void EtherCatBus::tell_startup_notes() {
  const auto& all = master_.startup_notes();
  while (startup_notes_told_ < all.size()) tell(events::StartupNoted{all[startup_notes_told_++]}, Severity::kNotice);
}

void EtherCatBus::tell_services() {
  for (auto& event : services_.poll()) {
    const auto severity = event.is<events::EoeAddressRefused>() ? Severity::kFault : Severity::kNotice;
    tell(std::move(event), severity);
  }
}

/// Tells of foreign frames: another master on the wire explains many other faults.
void EtherCatBus::tell_traffic() {
  auto traffic = master_.exchange_statistics();
  if (const auto* core = master_.core(); core != nullptr) traffic.frames_foreign += core->foreign_frames();
  if (traffic.frames_foreign + traffic.frames_of_masters > 0) tell(events::ForeignTraffic{traffic}, Severity::kNotice);
}

EventFacts EtherCatBus::with_link(const EventFacts& facts) const {
  if (const auto* found = facts.as<events::CommunicationLost>()) {
    auto lost = *found;
    lost.link = session_.no_link();
    return lost;
  }
  const auto* found = facts.as<events::AxesStopped>();
  if (found == nullptr || found->failure.cause != motion::MotionFailure::Cause::kCommunication) return facts;
  auto stopped = *found;
  stopped.link = session_.no_link();
  return stopped;
}

void EtherCatBus::report(RunReport& report) {
  for (const auto& wire : session_.wires()) {
    report.interfaces.push_back({wire.interface, wire.access_method, wire.steps_down});
  }
  report.statistics = master_.core()->statistics();
  if (const auto* runner = master_.runner()) {
    report.thread = runner->usage();
    report.wake_ahead = runner->wake_ahead().value_or(std::chrono::nanoseconds{0});
  }
  report.round_trip_modelled = !config_.interface.has_value();
  report.process_data = view_image(config_, master_, master_.core()->groups(), &group_watch_);
  report_clocks(report);
  if (const auto* ring = session_.ring()) {
    report.ring = {ring->status(), ring->merged(), ring->halves(), ring->late_halves()};
  }
  if (config_.axes.empty()) report.inputs = read_inputs(process_data_->variables, master_.core()->image().inputs());
  report.eoe = services_.eoe();
  report.gateway_clients = services_.clients();
  if (watch_) report.recoveries = watch_->supervisor().recoveries();
}

void EtherCatBus::report_clocks(RunReport& report) {
  const auto* watch = master_.clock_watch();
  if (watch == nullptr) return;
  auto& follower = *master_.clock_follower();
  auto& clocks = report.clocks.emplace();
  clocks.locked = follower.status().locked;
  clocks.differences = watch->all_differences();
  clocks.phase_errors = follower.phase_errors();
  for (const auto& margin : margins_) {
    clocks.margins.push_back({config_.slaves[margin.slave].name, margin.report});
  }
}

}  // namespace driveline::runtime
