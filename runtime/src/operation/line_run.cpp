#include "operation/line_run.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <thread>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/files/output_file.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Interval of the supervision while the cycle runs.
constexpr auto kWatchInterval = milliseconds{20};
constexpr auto kStopTimeout = std::chrono::seconds{10};
/// Cycles that the telemetry rings hold: a quarter of a second at 8 kHz.
constexpr std::size_t kRingCycles = 2048;
constexpr std::size_t kMaxRingSamples = 1 << 17;

}  // namespace

LineRun::LineRun(LineBus& bus, Settings settings)
    : bus_(bus),
      config_(bus.config()),
      settings_(std::move(settings)),
      line_ring_(kRingCycles),
      axis_ring_(std::clamp<std::size_t>(config_.axes.size() * kRingCycles, 1, kMaxRingSamples)) {
  bus_.listen({[this](EventFacts facts, Severity severity) { note(std::move(facts), severity); },
               [this] { tell_slaves(true); }});
}

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
  if (auto ready = bus_.prepare(); !ready) return ready;
  if (auto possible = check_stream(); !possible) return possible;
  if (auto possible = check_profile_axes(); !possible) return possible;
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
  if (auto up = bus_.bring_up(settings_.force); !up) return up;
  std::vector<double> unreported(config_.axes.size());
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    recorder_->set_scale(i, config_.axes[i].increments_per_unit);
    if (bus_.lacks_velocity(i)) unreported[i] = config_.axes[i].limits.max_velocity;
  }
  velocities_->estimate(unreported);
  if (auto* driven = settings_.tasks->make_source(config_)) settings_.source = driven;
  if (settings_.path) {
    if (auto made = make_motion(); !made) return made;
  }
  return settings_.tasks->prepare(config_, bus_.process_data().variables);
}

void LineRun::make_trace() {
  trace_ = std::make_unique<motion::CycleTrace>();
  if (bus_.virtual_time()) return;
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
  fault_records_ = std::make_unique<FaultRecords>(config_, motion_ != nullptr, !bus_.virtual_time());
  if (settings_.trace) make_trace();
  auto started = bus_.start({motion_ ? &motion_->control() : nullptr,
                             {&line_ring_, &axis_ring_},
                             settings_.tasks->schedule(),
                             fault_records_.get(),
                             trace_.get()});
  if (!started) return started;
  state_ = bus_.state();
  if (feed_) feed_->set_state(snapshot::LineState::kOp);
  progress(events::StateReached{state_, true});
  return start_services();
}

Result<void> LineRun::start_services() {
  if (auto offered = bus_.start_services(); !offered) return offered;
  if (!stream_) return {};
  if (auto started = stream_->start(); !started) return started;
  progress(stream_->offer());
  if (commands_) commands_->attach(&stream_->remote());
  return {};
}

/// Waits while the cycle runs; on virtual time also waits for the telemetry to keep up.
void LineRun::pass(nanoseconds duration) {
  bus_.pass(duration);
  while (bus_.virtual_time() && (line_ring_.size() > 0 || axis_ring_.size() > 0)) {
    std::this_thread::sleep_for(std::chrono::microseconds{100});
  }
}

double LineRun::seconds_in_operation() const {
  return std::chrono::duration<double>(operation_time_).count();
}

void LineRun::begin_operation() {
  // The figures of the report cover only the time in operation.
  bus_.count(false);
  pass(2 * config_.period);
  bus_.count(true);
  recorder_->begin_operation(bus_.clock().now());
  bus_.begin_operation(motion_.get());
  operating_ = true;
  operation_start_ = bus_.clock().now();
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
    pass(kWatchInterval - (bus_.clock().now() - operation_start_) % kWatchInterval);
    operation_time_ = bus_.clock().now() - operation_start_;
  } while (poll());
  bus_.count(false);
  if (!had(Severity::kFault)) bus_.read_figures();
  if (stop_requested()) progress(events::StopRequested{});
  recorder_->end_operation(bus_.clock().now());
  bus_.end_operation();
  state_ = bus_.state();
  stop_motion();
}

/// Runs one round of supervision. False: the operation is over.
bool LineRun::poll() {
  const bool over = settings_.duration_s && seconds_in_operation() >= *settings_.duration_s;
  if (over) bus_.count(false);
  if (auto recorded = fault_records_->poll()) progress(std::move(*recorded));
  const bool goes_on = bus_.look();
  state_ = bus_.state();
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

void LineRun::tell_progress() {
  if (seconds_in_operation() < next_progress_s_) return;
  next_progress_s_ += bus_.virtual_time() ? 10.0 : 1.0;
  progress(motion_ ? motion_->progress() : events::Progress{});
}

void LineRun::note(EventFacts facts, Severity severity) {
  Event event{std::move(facts), severity, {}};
  if (operating_ || severity != Severity::kProgress) event.time = operation_time_;
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
  if (!bus_.answers()) return;
  motion_->request_stop();
  const auto deadline = bus_.clock().now() + kStopTimeout;
  do {
    pass(kWatchInterval);
    note_streams();
    note_requests();
  } while (!motion_->off() && bus_.clock().now() < deadline);
  if (!motion_->off()) fail_with(events::AxesNotOff{kStopTimeout});
}

void LineRun::take_down() {
  settings_.axis_requests->close();
  bus_.stop_services();
  if (feed_) feed_->set_state(snapshot::LineState::kDown);
  const bool down = bus_.take_down();
  if (commands_) commands_->attach(nullptr);
  if (down) {
    progress(events::StateReached{bus_.state(), false});
    tell_slaves(true);
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

}  // namespace driveline::runtime
