#include "operation/line_run.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <stdexcept>
#include <thread>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/runtime/operation/configure_line.hpp"
#include "driveline/runtime/setup/clock_plan.hpp"
#include "driveline/runtime/setup/clock_text.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/drive_facts.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/runtime/setup/wire_budget.hpp"
#include "operation/axis_verdict.hpp"
#include "operation/joint_motion.hpp"
#include "operation/single_motion.hpp"
#include "telemetry/sealed_copy.hpp"
#include "telemetry/security_files.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Interval of the supervision while the cycle runs.
constexpr auto kWatchInterval = milliseconds{20};
/// Longer than the watchdogs of process data, so that a line whose master has died has left OP by then.
constexpr auto kListenForMasters = milliseconds{150};
/// Axes that have not been enabled for so long when a signal ends the run are a fault.
constexpr auto kTimeToEnable = std::chrono::seconds{1};
constexpr auto kStopTimeout = std::chrono::seconds{10};
/// Cycles the telemetry rings hold: a quarter of a second at 8 kHz.
constexpr std::size_t kRingCycles = 2048;
constexpr std::size_t kMaxRingSamples = 1 << 17;
/// Between two looks into them: how long a sample may lie there before readers of the telemetry get it.
constexpr auto kDrainPeriod = std::chrono::microseconds{500};

/// Of the columns of the flight recorder.
std::vector<ecat_master::FlightRecorder::AxisLabel> axis_labels(const LineConfig& config) {
  std::vector<ecat_master::FlightRecorder::AxisLabel> labels;
  for (const auto& axis : config.axes) {
    const auto& unit = ecat_master::position_unit(axis);
    const bool si = unit.name == trajectory::si_unit(unit.kind);
    labels.push_back({axis.name, si ? nullptr : &unit, config.output.increments ? axis.increments_per_unit : 0.0});
  }
  return labels;
}

}  // namespace

LineRun::LineRun(Session& session, Settings settings)
    : session_(session),
      config_(session.config()),
      settings_(std::move(settings)),
      line_ring_(kRingCycles),
      axis_ring_(std::clamp<std::size_t>(config_.axes.size() * kRingCycles, 1, kMaxRingSamples)),
      group_watch_(config_.process_data),
      master_(session.port(), session.clock(), master_settings(config_)),
      services_(config_) {}

LineRun::~LineRun() = default;

Result<RunReport> LineRun::execute() {
  auto up = prepare();
  if (up) {
    up = bring_up();
    if (up) up = start_cycle();
    if (up) {
      operate();
    } else {
      recorder_->discard();
    }
    take_down();
  }
  if (up) return make_report();
  leave_nothing_behind();
  return tl::unexpected(up.error());
}

void LineRun::leave_nothing_behind() {
  drain_.reset();
  recorder_.reset();
  std::error_code ignored;  // the folder stays when there is something else in it
  if (created_directory_) std::filesystem::remove(config_.output.directory, ignored);
}

Result<void> LineRun::prepare() {
  if (auto ready = services_.prepare(session_); !ready) return ready;
  if (auto possible = check_stream(); !possible) return possible;
  if (auto possible = check_commands(); !possible) return possible;
  std::error_code error;
  created_directory_ = std::filesystem::create_directories(config_.output.directory, error);
  if (error)
    return fail(ErrorKind::kMachine, fmt::format("cannot be created: {}", error.message()),
                config_.output.directory.string());
  auto alone = FolderLock::take(config_.output.directory);
  if (!alone) return tl::unexpected(alone.error());
  folder_ = std::move(*alone);
  const auto every = std::max<std::int64_t>(1, milliseconds{1} / config_.period);
  recorder_ = std::make_unique<Recorder>(
      config_.axes, config_.axes.empty() ? std::nullopt : std::optional(config_.output.directory / "axes.csv"),
      static_cast<std::uint64_t>(every), config_.output.increments, compensates_dead_time(config_));
  if (recorder_->problem()) return tl::unexpected(*recorder_->problem());
  return start_telemetry();
}

Result<void> LineRun::check_stream() const {
  if (!config_.stream) return {};
  if (session_.virtual_time()) {
    return fail(ErrorKind::kSetting, "goes with the time of this machine: its clients cannot follow virtual time",
                "[stream]");
  }
  const auto owner = joint_owner();
  if (owner.empty()) return {};
  return fail(
      ErrorKind::kSetting,
      fmt::format("the axes are moved together, by the {} of this run: nobody can stream to one of them", owner),
      "[stream]");
}

Result<void> LineRun::check_commands() const {
  if (!config_.commands) return {};
  if (session_.virtual_time()) {
    return fail(ErrorKind::kSetting, "go with the time of this machine: leases of virtual time mean nothing to clients",
                "[commands]");
  }
  if (settings_.telemetry) return {};
  return fail(ErrorKind::kSetting, "come by the process that publishes the line, but this run has no telemetry",
              "[commands]");
}

/// What moves all axes together, with a firm lease; empty: nothing.
std::string_view LineRun::joint_owner() const noexcept {
  if (settings_.tasks->drive()) return "task";
  if (settings_.source != nullptr) return "program";
  return config_.path ? "path" : "";
}

/// A machine without the bridge runs lines all the same, unless somebody has asked for telemetry.
Result<void> LineRun::start_bridge() {
  if (!settings_.telemetry || !config_.telemetry.enabled) return {};
  Result<std::filesystem::path> program;
  if (!config_.telemetry.service) program = TelemetryService::find_program();
  if (!program) {
    if (config_.telemetry.asked.value_or(false) || config_.commands) return tl::unexpected(program.error());
    note(events::TelemetryOff{describe(program.error())}, Severity::kNotice);
    return {};
  }
  BridgeSupervisor::Settings settings{.program = std::move(*program)};
  if (auto copied = copy_bridge_files(settings); !copied) return copied;
  if (auto ready = start_commands(); !ready) return ready;
  if (commands_) settings.commands = commands_->descriptors();
  auto started = TelemetryService::start(config_, session_.virtual_time(), std::move(settings));
  if (!started) return tl::unexpected(started.error());
  telemetry_ = std::move(*started);
  return {};
}

/// The bridge may open no file.
Result<void> LineRun::copy_bridge_files(BridgeSupervisor::Settings& settings) {
  const auto& telemetry = config_.telemetry;
  if (telemetry.security) {
    auto files = open_security_files(*telemetry.security);
    if (!files) return tl::unexpected(files.error());
    security_ = std::move(*files);
    for (const auto& file : security_) settings.security.push_back(file.get());
  }
  if (!telemetry.qos_profiles) return {};
  const auto content = read_input_file(*telemetry.qos_profiles);
  if (!content) return tl::unexpected(content.error());
  auto copy = sealed_copy(*content, *telemetry.qos_profiles);
  if (!copy) return tl::unexpected(copy.error());
  qos_profiles_ = std::move(*copy);
  settings.qos_profiles = qos_profiles_.get();
  settings.qos_file = telemetry.qos_profiles->string();
  return {};
}

Result<void> LineRun::start_commands() {
  if (!config_.commands) return {};
  auto started = CommandService::start(*settings_.door, config_.commands->lease_timeout);
  if (!started) return tl::unexpected(started.error());
  commands_ = std::move(*started);
  note(events::CommandsOpen{config_.commands->insecure}, Severity::kNotice);
  return {};
}

Result<void> LineRun::start_telemetry() {
  if (auto started = start_bridge(); !started) return started;
  figures_ = std::make_unique<CycleFigures>(config_.period);
  auto listeners = settings_.consumers;
  if (telemetry_) listeners.push_back(telemetry_.get());
  feed_ = std::make_unique<StatusFeed>(listeners, config_.period);
  std::vector<snapshot::SampleConsumer*> consumers{recorder_.get(), figures_.get(), feed_.get()};
  consumers.insert(consumers.end(), listeners.begin(), listeners.end());
  drain_ = std::make_unique<snapshot::DrainThread>(line_ring_, axis_ring_, std::move(consumers),
                                                   snapshot::DrainConfig{.period = kDrainPeriod});
  if (auto started = drain_->start(); !started) return fail(ErrorKind::kMachine, describe(started.error()));
  return {};
}

Result<void> LineRun::bring_up() {
  if (auto free = must_be_free(); !free) return free;
  if (auto done = master_.scan(); !done) return fail_line(done.error());
  progress(events::SlavesFound{master_.slaves().size()});
  for (const auto& wire : session_.wires()) {
    progress(events::InterfaceOpened{wire.interface, wire.way, wire.steps_down});
  }
  tell_problems(master_, *settings_.observer);
  if (!session_.has_config()) {
    session_.use_found_slaves(describe_found(master_.slaves()));
    config_.slaves = session_.config().slaves;
    progress(events::NoDescription{});
  }
  if (auto checked = check_planned_pdos(config_, master_.slaves()); !checked) return checked;
  if (config_.clocks) {
    if (auto planned = bring_up_clocks(); !planned) return planned;
  }
  if (auto done = configure_line(master_, &config_, *settings_.observer); !done) return done;
  state_ = "SAFEOP";
  if (telemetry_) slave_watch_.emplace(master_, session_.clock());
  tell_slaves(true);
  if (auto complete = check_axis_objects(config_, master_); !complete) return complete;
  if (auto asked = ask_drives(); !asked) return asked;
  auto named = name_process_data(config_, master_);
  if (!named) return tl::unexpected(named.error());
  copies_ = std::move(named->copies);
  variables_ = std::move(named->variables);
  const auto wire = wire_budget(master_, config_);
  const auto& image = master_.image();
  progress(events::Configured{image.outputs().size(), image.frame_count(), wire, config_.interface.has_value()});
  if (image.outputs().empty() && image.inputs().empty()) progress(events::NoProcessData{});
  if (auto fits = check_budget(wire, config_.interface.has_value()); !fits) return fits;
  if (auto* driven = settings_.tasks->make_source(config_)) settings_.source = driven;
  if (settings_.path) {
    if (auto made = make_motion(); !made) return made;
  }
  return settings_.tasks->prepare(config_, *variables_);
}

Result<void> LineRun::bring_up_clocks() {
  // The plan assigns SYNC signals to slaves: those planned by device ID must be identified before.
  const auto by_id = [](const SlaveConfig& slave) { return slave.plan.device_id.has_value(); };
  if (std::any_of(config_.slaves.begin(), config_.slaves.end(), by_id)) {
    if (auto done = master_.identify_devices(); !done) return fail_line(done.error());
  }
  auto plan = make_clock_plan(config_, master_.slaves(), session_.virtual_time());
  if (!plan) return tl::unexpected(plan.error());
  master_.use_clocks(std::move(*plan));
  if (session_.ring() != nullptr) master_.use_ring(*session_.ring());
  progress(events::ClocksBeingSet{});
  return {};
}

/// Completes the axes by what their drives tell.
Result<void> LineRun::ask_drives() {
  const auto facts = read_drive_facts(master_, config_);
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    if (!facts[i]) return fail_line(facts[i].error());
    auto& axis = config_.axes[i];
    const auto difference = take_drive_facts(axis, *facts[i]);
    if (!difference) return tl::unexpected(difference.error());
    if (*difference)
      note(events::ScaleDiffers{axis.name, (*difference)->described, (*difference)->told}, Severity::kNotice);
    recorder_->set_scale(i, axis.increments_per_unit);
  }
  return {};
}

/// Refuses a line that another master drives. Masters of this program hold a claim (Session::claim()), others are
/// recognised by their frames.
Result<void> LineRun::must_be_free() {
  if (settings_.force || !config_.interface) return {};
  const auto owner = master_.find_owner(kListenForMasters);
  // A line without slaves is reported by scan().
  if (!owner || !owner->in_op) return {};
  if (owner->heard) {
    return fail(ErrorKind::kLineDriven,
                fmt::format("slave {} is in OP and {}: this would take his line away", *owner->in_op,
                            ecat_master::describe_traffic(master_.exchange_statistics())));
  }
  progress(events::TakenOver{*owner->in_op, kListenForMasters});
  return {};
}

/// Axes that nothing moves together wait for requests, each for its own.
Result<void> LineRun::make_motion() {
  if (!joint_owner().empty()) {
    motion_ = make_joint_motion();
    return {};
  }
  auto made = make_single_motion();
  if (!made) return tl::unexpected(made.error());
  motion_ = std::move(*made);
  return {};
}

Result<std::unique_ptr<LineMotion>> LineRun::make_single_motion() {
  auto axes = std::make_unique<ecat_master::SingleAxes>(make_axes(config_, master_), single_axis_settings(config_));
  for (const auto& gantry : config_.gantries) axes->add_gantry(gantry);
  if (config_.stream) {
    stream_ = std::make_unique<StreamService>(config_, *axes, settings_.door->authority());
    settings_.tasks->serve(stream_->task());
  }
  auto& single = *axes;
  auto motion = std::make_unique<SingleMotion>(std::move(axes), *settings_.door, settings_.enable);
  if (auto added = add_groups(*motion, single); !added) return tl::unexpected(added.error());
  if (auto added = add_couplings(single); !added) return tl::unexpected(added.error());
  return motion;
}

/// Before the couplings: an axis of a group may lead another one, which follows its setpoint of the same cycle.
Result<void> LineRun::add_groups(SingleMotion& motion, ecat_master::SingleAxes& axes) {
  if (config_.axis_groups.empty()) return {};
  auto outputs = GroupOutputs::make(config_, *variables_, copies_);
  if (!outputs) return tl::unexpected(outputs.error());
  group_outputs_ = std::move(*outputs);
  std::vector<ecat_master::GroupConfig> groups;
  std::vector<std::vector<GroupOutputLimits>> limits;
  for (std::size_t i = 0; i < config_.axis_groups.size(); ++i) {
    const auto& described = config_.axis_groups[i];
    auto& group = groups.emplace_back(ecat_master::GroupConfig{described.name, described.axes});
    if (described.machine) group.kinematics = &described.machine->kinematics();
    group.tool = described.tool;
    auto& values = limits.emplace_back();
    if (!group_outputs_[i]) continue;
    group.outputs = group_outputs_[i].get();
    values = group_outputs_[i]->limits();
    settings_.tasks->serve(*group_outputs_[i], {.order = ecat_master::TaskTiming::Order::kAfterMotion});
  }
  try {
    motion.add(std::make_unique<ecat_master::AxisGroups>(axes, std::move(groups), config_.period), std::move(limits),
               *settings_.groups, !session_.virtual_time());
  } catch (const std::invalid_argument& wrong) {
    return fail(ErrorKind::kSetting, wrong.what(), "[[axis_group]]");
  }
  return {};
}

Result<void> LineRun::add_couplings(ecat_master::SingleAxes& axes) {
  if (config_.couplings.couplings.empty()) return {};
  auto couplings = LineCouplings::make(config_, axes, *variables_, master_);
  if (!couplings) return tl::unexpected(couplings.error());
  couplings_ = std::move(*couplings);
  settings_.door->attach(*couplings_);
  return {};
}

std::unique_ptr<LineMotion> LineRun::make_joint_motion() {
  auto axes = make_axes(config_, master_);
  const auto settings = motion_settings(config_);
  auto motion = settings_.source != nullptr
                    ? std::make_unique<ecat_master::Motion>(std::move(axes), *settings_.source, settings)
                    : std::make_unique<ecat_master::Motion>(std::move(axes), *settings_.path, settings);
  return std::make_unique<JointMotion>(std::move(motion), config_, *settings_.door, std::string(joint_owner()));
}

void LineRun::make_trace() {
  trace_ = std::make_unique<ecat_master::CycleTrace>();
  if (session_.virtual_time()) return;
  if (!config_.realtime.cpu) {
    switches_unknown_ =
        "which threads ran instead of the cycle cannot be seen where it has no CPU of its own ([realtime] cpu)";
    return;
  }
  auto switches = rt::SwitchLog::open(*config_.realtime.cpu);
  if (!switches) {
    switches_unknown_ = switches.error().message();
    return;
  }
  switches_ = std::move(*switches);
  trace_->watch(*switches_);
}

Result<void> LineRun::start_cycle() {
  auto settings = cycle_settings(config_, master_);
  settings.copies = copies_;
  settings.tasks = settings_.tasks->schedule();
  fault_records_ = std::make_unique<FaultRecords>(
      config_.output.directory, motion_ ? axis_labels(config_) : std::vector<ecat_master::FlightRecorder::AxisLabel>{},
      !session_.virtual_time());
  settings.recorder = &fault_records_->recorder();
  if (settings_.trace) make_trace();
  settings.trace = trace_.get();
  auto make_runner = [this](ecat_master::CyclicCore& core) -> std::unique_ptr<ecat_master::CycleRunner> {
    if (session_.virtual_time()) return std::make_unique<ecat_master::InlineRunner>(core, session_.clock());
    return std::make_unique<ecat_master::RealtimeRunner>(core, session_.clock(), config_.realtime, config_.wake_ahead);
  };
  auto started =
      master_.start_cycle(motion_ ? &motion_->control() : nullptr, {&line_ring_, &axis_ring_}, settings, make_runner);
  if (!started) return fail(ErrorKind::kMachine, started.error().message());
  if (const auto* runner = dynamic_cast<ecat_master::RealtimeRunner*>(master_.runner())) {
    progress(events::RealtimeSetUp{runner->report()});
  }
  if (auto done = master_.go_operational(); !done)
    return tl::unexpected(Error{ErrorKind::kLine, {}, with_clock_remedy(done.error()), {}, 0, done.error()});
  if (auto* watch = master_.clock_watch()) {
    progress(events::ClocksLocked{watch->clocks().reference, master_.clock_follower()->status().ppm});
  }
  state_ = "OP";
  if (feed_) feed_->set_state(snapshot::LineState::kOp);
  progress(events::StateReached{wire::AlState::kOp});
  return start_services();
}

Result<void> LineRun::start_services() {
  if (auto offered = services_.start(master_); !offered) return offered;
  for (auto& offer : services_.offers()) progress(std::move(offer));
  if (!stream_) return {};
  if (auto started = stream_->start(); !started) return started;
  progress(stream_->offer());
  if (commands_) commands_->attach(&stream_->remote());
  return {};
}

/// Lets time pass beside the cycle; on virtual time waits for the telemetry to keep up.
void LineRun::pass(nanoseconds duration) {
  master_.pass(duration);
  while (session_.virtual_time() && (line_ring_.size() > 0 || axis_ring_.size() > 0)) {
    std::this_thread::sleep_for(std::chrono::microseconds{100});
  }
}

double LineRun::seconds_in_operation() const {
  return std::chrono::duration<double>(operation_time_).count();
}

void LineRun::begin_operation() {
  // The figures of the report are those of the time in operation.
  master_.core()->count(false);
  pass(2 * config_.period);
  master_.core()->count(true);
  if (auto* watch = master_.clock_watch()) watch->restart_statistics();
  recorder_->begin_operation(session_.clock().now());
  make_watch();
  operation_start_ = session_.clock().now();
  settings_.observer->look();
  tell_slaves(true);
  // The line is up; after a stop request nothing moves any more.
  if (motion_ && !stop_requested()) motion_->start();
  if (motion_ && joint_owner().empty()) progress(events::NoPath{settings_.enable});
}

void LineRun::operate() {
  begin_operation();
  // On a grid: the supervision itself takes time, and the run is to last exactly as long as requested.
  do {
    pass(kWatchInterval - (session_.clock().now() - operation_start_) % kWatchInterval);
    operation_time_ = session_.clock().now() - operation_start_;
  } while (look());
  master_.core()->count(false);
  if (!had(Severity::kFault)) margins_ = read_sync_margins(master_);
  if (stop_requested()) progress(events::StopRequested{});
  recorder_->end_operation(session_.clock().now());
  watch_->tell_missing();
  state_ = watch_->state();
  stop_motion();
}

/// One round of supervision. False: the operation is over.
bool LineRun::look() {
  const bool over = settings_.duration_s && seconds_in_operation() >= *settings_.duration_s;
  if (over) master_.core()->count(false);
  for (auto& change : group_watch_.poll(*master_.core())) progress(std::move(change));
  if (auto recorded = fault_records_->poll()) progress(std::move(*recorded));
  for (auto& refused : services_.poll()) note(std::move(refused), Severity::kFault);
  const bool goes_on = watch_->look();
  state_ = watch_->state();
  if (!goes_on || stop_requested()) return false;
  settings_.observer->look();
  if (over || stop_requested()) return false;
  note_requests();
  note_streams();
  note_telemetry();
  tell_slaves(false);
  if (!settings_.duration_s && motion_ && motion_->done()) return false;
  tell_progress();
  return true;
}

void LineRun::tell_progress() {
  if (seconds_in_operation() < next_progress_s_) return;
  next_progress_s_ += session_.virtual_time() ? 10.0 : 1.0;
  progress(motion_ ? motion_->progress() : events::Progress{});
}

void LineRun::make_watch() {
  auto listener = [this](EventFacts facts, Severity severity) {
    using Cause = ecat_master::MotionFailure::Cause;
    if (auto* lost = std::get_if<events::CommunicationLost>(&facts)) lost->link = session_.no_link();
    if (auto* stopped = std::get_if<events::AxesStopped>(&facts);
        stopped != nullptr && stopped->failure.cause == Cause::kCommunication)
      stopped->link = session_.no_link();
    note(std::move(facts), severity);
  };
  watch_ = std::make_unique<LineWatch>(master_, session_.ring(), motion_.get(), config_, session_.clock(),
                                       std::move(listener));
}

ecat_master::Result<ecat_master::LineDiagnosis> LineRun::diagnose() {
  auto diagnosis = ecat_master::diagnose(master_, &watch_->supervisor(), session_.ring());
  if (!diagnosis) return diagnosis;
  diagnosis->statistics = figures_->snapshot();
  diagnosis->round_trip_modelled = !config_.interface.has_value();
  return diagnosis;
}

void LineRun::note(EventFacts facts, Severity severity) {
  Event event{std::move(facts), severity, {}};
  if (watch_ || severity != Severity::kProgress) event.time = operation_time_;
  settings_.observer->event(event);
  if (event.is_fault()) {
    if (feed_) feed_->add_fault(describe(event, config_.output.increments));
    if (fault_records_) fault_records_->note_fault();
  }
  // What goes on as it should is no news; that a state has been reached is.
  if (telemetry_ && (severity != Severity::kProgress || event.is<events::StateReached>()))
    telemetry_->tell(severity, describe(event, config_.output.increments));
  if (severity == Severity::kProgress) return;
  worst_ = std::max(worst_, severity);
  events_.add(std::move(event));
}

/// What was asked of single axes, and what has become of it.
void LineRun::note_requests() {
  settings_.door->watch();
  settings_.groups->watch();
  for (auto& event : settings_.door->take_events()) note(std::move(event), Severity::kNotice);
  for (auto& event : settings_.groups->take_events()) note(std::move(event), Severity::kNotice);
  for (auto& change : settings_.door->authority().take_changes())
    authority_.add({seconds_in_operation(), config_.axes[change.axis].name, std::move(change)});
}

/// Who streams setpoints, and what is wrong with them.
void LineRun::note_streams() {
  if (!stream_) return;
  for (auto& event : stream_->poll()) note(std::move(event.facts), event.severity);
}

/// What becomes of the bridge is no fault of the line, but subscribers are to know.
void LineRun::note_telemetry() {
  if (!telemetry_) return;
  for (auto& facts : telemetry_->poll()) {
    const bool stopped = std::holds_alternative<events::BridgeStopped>(facts);
    if (stopped && commands_) commands_->bridge_lost();
    note(std::move(facts), Severity::kNotice);
    if (stopped && feed_) feed_->add_fault(describe(events_.newest()));
  }
}

/// For subscribers: `now`, or when something has changed or it is time.
void LineRun::tell_slaves(bool now) {
  if (!slave_watch_) return;
  std::vector<std::string> owners;
  for (std::size_t i = 0; i < config_.axes.size(); ++i) owners.push_back(settings_.door->authority().owner_of(i));
  bool changed = slave_watch_->set_owners(owners) || now;
  if (now) {
    slave_watch_->read();
  } else {
    changed = slave_watch_->look() || changed;
  }
  if (!changed) return;
  telemetry_->set_condition(slave_watch_->condition());
}

void LineRun::stop_motion() {
  if (!motion_) return;
  note_requests();
  note_groups();
  if (stream_) stream_->close();
  if (commands_) commands_->end_streams();
  if (!had(Severity::kFailure)) {
    motion_->judge([this](EventFacts facts, Severity severity) { note(std::move(facts), severity); });
  }
  // No slave would receive it.
  if (master_.core()->al_status().slaves == 0) return;
  motion_->request_stop();
  const auto deadline = session_.clock().now() + kStopTimeout;
  do {
    pass(kWatchInterval);
    note_streams();
    note_requests();
  } while (!motion_->off() && session_.clock().now() < deadline);
  if (!motion_->off()) fail_with(events::AxesNotOff{kStopTimeout});
}

/// Before the axes come to rest for the end of the run.
void LineRun::note_groups() {
  for (std::size_t group = 0; group < config_.axis_groups.size(); ++group) {
    const auto status = settings_.groups->status(group);
    AxisGroupReport report{config_.axis_groups[group].name, {}, {}, status.owner, {}, {}, {}};
    for (const auto& axis : status.limits.group.axes) report.axes.push_back(axis.name);
    report.machine = config_.axis_groups[group].machine;
    report.coordinates = status.limits.group.coordinates;
    report.place = status.place;
    if (status.report) report.state = to_text(status.report->state);
    groups_.push_back(std::move(report));
  }
}

void LineRun::take_down() {
  settings_.door->close();
  services_.stop();
  tell_traffic();
  if (feed_) feed_->set_state(snapshot::LineState::kDown);
  const auto down = master_.shut_down();
  if (commands_) commands_->attach(nullptr);
  if (down) {
    progress(events::StateReached{wire::AlState::kInit});
    tell_slaves(true);
  } else {
    fail_with(events::NotInInit{down.error()});
  }
  if (drain_) drain_->stop();
  note_telemetry();
  judge_axes();
  judge_tasks();
  if (recorder_ && recorder_->problem()) fail_with(events::FileNotWritten{*recorder_->problem()});
  if (const auto end = recorder_ ? recorder_->cut_off_at_s() : std::nullopt)
    note(events::RecordingEnded{*end, recorder_->rows()}, Severity::kNotice);
  if (operation_time_ > nanoseconds{0}) finish_fault_records();
}

/// For a run without any other failure.
void LineRun::judge_axes() {
  if (!motion_ || had(Severity::kFailure) || operation_time_ == nanoseconds{0}) return;
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    const auto& axis = config_.axes[i];
    const auto& seen = recorder_->following_errors()[i];
    if (axis.is_virtual()) continue;
    // A run stopped at its very beginning does not wait for them.
    if (seen.samples == 0 && stop_requested() && operation_time_ < kTimeToEnable) continue;
    if (seen.samples == 0 && !motion_->enables()) continue;
    const auto period = config_.period * exchange_divider(config_, config_.slaves[axis.slave]);
    if (auto verdict = axis_verdict(axis, seen, period)) fail_with(std::move(*verdict));
  }
}

/// Forbidden calls are counted in a debug build only.
void LineRun::judge_tasks() {
  for (const auto& task : settings_.tasks->report()) {
    if (const auto calls = task.figures.forbidden_calls; calls > 0) fail_with(events::ForbiddenCalls{task.name, calls});
  }
}

/// Another master on the wire explains much of what else went wrong.
void LineRun::tell_traffic() {
  auto traffic = master_.exchange_statistics();
  if (const auto* core = master_.core(); core != nullptr) traffic.frames_foreign += core->foreign_frames();
  if (traffic.frames_foreign + traffic.frames_of_masters > 0) note(events::ForeignTraffic{traffic}, Severity::kNotice);
}

/// After the cycle has ended.
void LineRun::finish_fault_records() {
  for (auto& recorded : fault_records_->finish()) progress(std::move(recorded));
  if (fault_records_->problem()) fail_with(events::FileNotWritten{*fault_records_->problem()});
}

RunReport LineRun::make_report() {
  RunReport report;
  report.line = config_.name;
  report.state = state_;
  report.increments = config_.output.increments;
  report.period = config_.period;
  for (const auto& wire : session_.wires()) {
    report.interfaces.push_back({wire.interface, wire.way, wire.steps_down});
  }
  report.duration_s = seconds_in_operation();
  report.statistics = master_.core()->statistics();
  if (const auto* runner = master_.runner()) {
    report.thread = runner->usage();
    report.wake_ahead = runner->wake_ahead().value_or(nanoseconds{0});
  }
  if (trace_) report.trace = trace_->cycles();
  report.trace_without_switches = switches_unknown_;
  if (motion_) report.path_late = motion_->control().path_late();
  report.longest_absence_at_s =
      std::chrono::duration<double>(report.statistics.longest_absence_at - operation_start_).count();
  report.round_trip_modelled = !config_.interface.has_value();
  report.process_data = view_image(config_, master_, master_.core()->groups(), &group_watch_);
  if (auto* watch = master_.clock_watch()) {
    const auto& follower = *master_.clock_follower();
    auto& clocks = report.clocks.emplace();
    clocks.locked = master_.clock_follower()->status().locked;
    clocks.differences = watch->all_differences();
    clocks.phase_errors = follower.phase_errors();
    for (const auto& margin : margins_) {
      clocks.margins.push_back({config_.slaves[margin.slave].name, margin.report});
    }
  }
  if (const auto* ring = session_.ring()) {
    report.ring = {ring->status(), ring->merged(), ring->halves(), ring->late_halves()};
  }
  report_axes(report);
  report.axis_groups = groups_;
  if (config_.axes.empty() && variables_) report.inputs = read_inputs(*variables_, master_.core()->image().inputs());
  report.tasks = settings_.tasks->report();
  report.eoe = services_.eoe();
  report.gateway_clients = services_.clients();
  if (telemetry_) report.telemetry = telemetry_->report();
  report.events = events_.all();
  report.events_left_out = events_.left_out();
  report.authority = authority_.all();
  if (watch_) report.recoveries = watch_->supervisor().recoveries();
  report_files(report);
  return report;
}

void LineRun::report_axes(RunReport& report) const {
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    const auto& axis = config_.axes[i];
    const auto& error = recorder_->following_errors()[i];
    const auto& unit = ecat_master::position_unit(axis);
    const auto slave = axis.is_virtual() ? std::nullopt : std::optional(axis.slave);
    report.axes.push_back({axis.name, slave, error.maximum * axis.increments_per_unit,
                           error.rms() * axis.increments_per_unit, std::string(unit.name),
                           axis.increments_per_unit * unit.to_si(1.0), error.unavailable});
    report.axes.back().path_error = {error.path.maximum * axis.increments_per_unit,
                                     error.path.rms() * axis.increments_per_unit};
    report.axes.back().owner = settings_.door->authority().owner_of(i);
    report.axes.back().demand_recorded = error.demand;
    if (error.drive.samples == 0) continue;
    report.axes.back().by_drive = {error.drive.maximum * axis.increments_per_unit,
                                   error.drive.rms() * axis.increments_per_unit};
  }
}

void LineRun::report_files(RunReport& report) const {
  if (recorder_->rows() > 0 && !recorder_->problem()) report.files["axes_csv"] = config_.output.directory / "axes.csv";
  const auto& records = fault_records_->files();
  for (std::size_t i = 0; i < records.size(); ++i) {
    report.files[i == 0 ? "flight_recorder_csv" : fmt::format("flight_recorder_{}_csv", i + 1)] = records[i];
  }
}

}  // namespace driveline::runtime
