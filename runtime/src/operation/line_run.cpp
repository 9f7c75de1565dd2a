#include "operation/line_run.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <thread>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/runtime/operation/configure_line.hpp"
#include "driveline/runtime/setup/clock_plan.hpp"
#include "driveline/runtime/setup/clock_text.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/drive_facts.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/runtime/setup/wire_budget.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Interval of the supervision while the cycle runs.
constexpr auto kWatchInterval = milliseconds{20};
/// Longer than the watchdogs of process data, so that a line whose master has died has left OP when this time has
/// passed.
constexpr auto kListenForMasters = milliseconds{150};
constexpr auto kStopTimeout = std::chrono::seconds{10};
/// Cycles that the telemetry rings hold: a quarter of a second at 8 kHz.
constexpr std::size_t kRingCycles = 2048;
constexpr std::size_t kMaxRingSamples = 1 << 17;

/// Returns the labels of the columns of the flight recorder.
std::vector<ecat_master::FlightRecorder::AxisLabel> axis_labels(const LineConfig& config) {
  std::vector<ecat_master::FlightRecorder::AxisLabel> labels;
  for (const auto& axis : config.axes) {
    const auto& unit = motion::position_unit(axis);
    const bool si = unit.name == trajectory::si_unit(unit.kind);
    labels.push_back({axis.name, si ? nullptr : &unit, config.output.increments ? axis.increments_per_unit : 0.0});
  }
  return labels;
}

/// Passes events on.
class EventForwarder final : public Observer {
 public:
  explicit EventForwarder(std::function<void(const Event&)> take) : take_(std::move(take)) {}
  void event(const Event& event) override { take_(event); }

 private:
  std::function<void(const Event&)> take_;
};

}  // namespace

LineRun::LineRun(Session& session, Settings settings)
    : session_(session),
      config_(session.config()),
      settings_(std::move(settings)),
      line_ring_(kRingCycles),
      axis_ring_(std::clamp<std::size_t>(config_.axes.size() * kRingCycles, 1, kMaxRingSamples)),
      exchange_group_watch_(config_.process_data),
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
  std::error_code ignored;  // the folder remains if it contains other files
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

Result<void> LineRun::bring_up() {
  if (auto free = must_be_free(); !free) return free;
  if (auto done = master_.scan(); !done) return fail_line(done.error());
  progress(events::SlavesFound{master_.slaves().size()});
  for (const auto& wire : session_.wires()) {
    progress(events::InterfaceOpened{wire.interface, wire.access_method, wire.steps_down});
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
  EventForwarder events([this](const Event& event) { note(event.facts, event.severity); });
  if (auto done = configure_line(master_, &config_, events); !done) return done;
  startup_notes_told_ = master_.startup_notes().size();
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
  // The plan assigns SYNC signals to slaves, so slaves with a planned device ID must be identified first.
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

/// Completes the axes with data from their drives.
Result<void> LineRun::ask_drives() {
  const auto facts = read_drive_facts(master_, config_);
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    if (!facts[i]) return fail_line(facts[i].error());
    auto& axis = config_.axes[i];
    const auto difference = take_drive_facts(axis, *facts[i]);
    if (!difference) return tl::unexpected(difference.error());
    if (*difference)
      note(events::ScaleDiffers{axis.name, (*difference)->described, (*difference)->reported_by_drive},
           Severity::kNotice);
    recorder_->set_scale(i, axis.increments_per_unit);
  }
  return {};
}

/// Refuses a line that another master controls. Masters of this program hold a claim (Session::claim()), others are
/// recognised by their frames.
Result<void> LineRun::must_be_free() {
  if (settings_.force || !config_.interface) return {};
  const auto owner = master_.find_owner(kListenForMasters);
  // A line without slaves is reported by scan().
  if (!owner || !owner->in_op) return {};
  if (owner->heard) {
    return fail(ErrorKind::kLineDriven,
                fmt::format("slave {} is in OP and {}: this run would interrupt the other master", *owner->in_op,
                            ecat_master::describe_traffic(master_.exchange_statistics())));
  }
  progress(events::TakenOver{*owner->in_op, kListenForMasters});
  return {};
}

void LineRun::make_trace() {
  trace_ = std::make_unique<motion::CycleTrace>();
  if (session_.virtual_time()) return;
  if (!config_.realtime.cpu) {
    switches_unknown_ =
        "threads that displaced the cycle are not recorded: the cycle has no CPU of its own ([realtime] cpu)";
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
  auto make_runner = [this](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
    if (session_.virtual_time()) return std::make_unique<motion::InlineRunner>(core, session_.clock());
    return std::make_unique<motion::RealtimeRunner>(core, session_.clock(), config_.realtime, config_.wake_ahead,
                                                    session_.launch_ahead());
  };
  auto started =
      master_.start_cycle(motion_ ? &motion_->control() : nullptr, {&line_ring_, &axis_ring_}, settings, make_runner);
  if (!started) return fail(ErrorKind::kMachine, started.error().message());
  if (const auto* runner = dynamic_cast<motion::RealtimeRunner*>(master_.runner())) {
    progress(events::RealtimeSetUp{runner->report()});
  }
  const auto operational = master_.go_operational();
  note_startup();
  if (!operational)
    return tl::unexpected(
        Error{ErrorKind::kLine, {}, with_clock_remedy(operational.error()), {}, 0, operational.error()});
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

/// Waits while the cycle runs; on virtual time also waits for the telemetry to keep up.
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
  // The figures of the report cover only the time in operation.
  master_.core()->count(false);
  pass(2 * config_.period);
  master_.core()->count(true);
  if (auto* watch = master_.clock_watch()) watch->restart_statistics();
  recorder_->begin_operation(session_.clock().now());
  make_watch();
  operation_start_ = session_.clock().now();
  settings_.observer->poll();
  tell_slaves(true);
  // The line is up; after a stop request no motion starts any more.
  if (motion_ && !stop_requested()) motion_->start();
  if (motion_ && joint_owner().empty()) progress(events::NoPath{settings_.enable});
}

void LineRun::operate() {
  begin_operation();
  // Keep to a fixed grid: the supervision itself takes time, and the run must last exactly as long as requested.
  do {
    pass(kWatchInterval - (session_.clock().now() - operation_start_) % kWatchInterval);
    operation_time_ = session_.clock().now() - operation_start_;
  } while (poll());
  master_.core()->count(false);
  if (!had(Severity::kFault)) margins_ = read_sync_margins(master_);
  if (stop_requested()) progress(events::StopRequested{});
  recorder_->end_operation(session_.clock().now());
  watch_->tell_rest();
  state_ = watch_->state();
  stop_motion();
}

/// Runs one round of supervision. False: the operation is over.
bool LineRun::poll() {
  const bool over = settings_.duration_s && seconds_in_operation() >= *settings_.duration_s;
  if (over) master_.core()->count(false);
  for (auto& change : exchange_group_watch_.poll(*master_.core())) progress(std::move(change));
  if (auto recorded = fault_records_->poll()) progress(std::move(*recorded));
  note_services();
  note_startup();
  const bool goes_on = watch_->poll();
  state_ = watch_->state();
  if (!goes_on || stop_requested()) return false;
  settings_.observer->poll();
  if (over || stop_requested()) return false;
  note_requests();
  note_streams();
  note_telemetry();
  tell_slaves(false);
  if (!settings_.duration_s && motion_ && motion_->done()) return false;
  tell_progress();
  return true;
}

/// Reports what slaves refused that were configured since the last call.
void LineRun::note_startup() {
  const auto& all = master_.startup_notes();
  while (startup_notes_told_ < all.size()) note(events::StartupNoted{all[startup_notes_told_++]}, Severity::kNotice);
}

void LineRun::note_services() {
  for (auto& event : services_.poll()) {
    const auto severity = event.is<events::EoeAddressRefused>() ? Severity::kFault : Severity::kNotice;
    note(std::move(event), severity);
  }
}

void LineRun::tell_progress() {
  if (seconds_in_operation() < next_progress_s_) return;
  next_progress_s_ += session_.virtual_time() ? 10.0 : 1.0;
  progress(motion_ ? motion_->progress() : events::Progress{});
}

EventFacts LineRun::with_link(const EventFacts& facts) const {
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

void LineRun::make_watch() {
  auto listener = [this](const EventFacts& facts, Severity severity) { note(with_link(facts), severity); };
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
  // Normal progress is not published, except that a state has been reached.
  if (telemetry_ && (severity != Severity::kProgress || event.is<events::StateReached>()))
    telemetry_->tell(severity, describe(event, config_.output.increments));
  if (severity == Severity::kProgress) return;
  worst_ = std::max(worst_, severity);
  events_.add(std::move(event));
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
  // Without a slave there is no receiver of a stop.
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

void LineRun::take_down() {
  settings_.axis_requests->close();
  services_.stop();
  note_services();
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
  if (const auto begin = recorder_ ? recorder_->begins_at_s() : std::nullopt)
    note(events::RecordingShortened{*begin, recorder_->rows()}, Severity::kNotice);
  if (operation_time_ > nanoseconds{0}) finish_fault_records();
}

/// Reports forbidden calls of tasks, which only a debug build counts.
void LineRun::judge_tasks() {
  for (const auto& task : settings_.tasks->report()) {
    if (const auto calls = task.figures.forbidden_calls; calls > 0) fail_with(events::ForbiddenCalls{task.name, calls});
  }
}

/// Reports foreign frames: another master on the wire explains many other faults.
void LineRun::tell_traffic() {
  auto traffic = master_.exchange_statistics();
  if (const auto* core = master_.core(); core != nullptr) traffic.frames_foreign += core->foreign_frames();
  if (traffic.frames_foreign + traffic.frames_of_masters > 0) note(events::ForeignTraffic{traffic}, Severity::kNotice);
}

}  // namespace driveline::runtime
