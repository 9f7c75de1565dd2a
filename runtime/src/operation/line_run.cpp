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

}  // namespace

LineRun::LineRun(LineBus& bus, RunMotion::Settings motion, Settings settings)
    : bus_(bus),
      config_(bus.config()),
      settings_(std::move(settings)),
      samples_(config_),
      motion_(bus, std::move(motion)) {
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
      samples_.recorder()->discard();
    }
    take_down();
  }
  if (up) return make_report();
  leave_nothing_behind();
  return tl::unexpected(up.error());
}

void LineRun::leave_nothing_behind() {
  samples_.close();
  std::error_code ignored;  // the folder remains if it contains other files
  if (created_directory_) std::filesystem::remove(config_.output.directory, ignored);
}

Result<void> LineRun::prepare() {
  if (auto ready = bus_.prepare(); !ready) return ready;
  if (auto possible = motion_.check(); !possible) return possible;
  if (auto possible = check_commands(); !possible) return possible;
  if (auto opened = open_folder(); !opened) return opened;
  if (auto opened = samples_.open_recorder(); !opened) return opened;
  return start_telemetry();
}

/// Makes the folder of the results, and locks it.
Result<void> LineRun::open_folder() {
  std::error_code error;
  created_directory_ = std::filesystem::create_directories(config_.output.directory, error);
  if (error)
    return fail(ErrorKind::kMachine, fmt::format("cannot be created: {}", error.message()),
                config_.output.directory.string());
  auto alone = FolderLock::take(config_.output.directory);
  if (!alone) return tl::unexpected(alone.error());
  folder_ = std::move(*alone);
  return {};
}

Result<void> LineRun::bring_up() {
  if (auto up = bus_.bring_up(settings_.force); !up) return up;
  std::vector<double> unreported(config_.axes.size());
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    if (bus_.lacks_velocity(i)) unreported[i] = config_.axes[i].limits.max_velocity;
  }
  samples_.complete(unreported);
  return motion_.make();
}

Result<void> LineRun::start_cycle() {
  fault_records_ = std::make_unique<FaultRecords>(config_, motion_.get() != nullptr, !bus_.virtual_time());
  if (settings_.trace) trace_.open(config_, bus_.virtual_time());
  auto started = bus_.start({motion_.get() ? &motion_.get()->control() : nullptr, samples_.rings(),
                             motion_.settings().tasks->schedule(), fault_records_.get(), trace_.cycles()});
  if (!started) return started;
  state_ = bus_.state();
  if (auto* feed = samples_.feed()) feed->set_state(snapshot::LineState::kOp);
  progress(events::StateReached{state_, true});
  return start_services();
}

Result<void> LineRun::start_services() {
  if (auto offered = bus_.start_services(); !offered) return offered;
  auto* stream = motion_.stream();
  if (!stream) return {};
  if (auto started = stream->start(); !started) return started;
  progress(stream->offer());
  if (commands_) commands_->attach(&stream->remote());
  return {};
}

/// Waits while the cycle runs; on virtual time also waits for the telemetry to keep up.
void LineRun::pass(nanoseconds duration) {
  bus_.pass(duration);
  while (bus_.virtual_time() && !samples_.caught_up()) {
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
  samples_.recorder()->begin_operation(bus_.clock().now());
  bus_.begin_operation(motion_.get());
  operating_ = true;
  operation_start_ = bus_.clock().now();
  settings_.observer->poll();
  tell_slaves(true);
  // The line is up; after a stop request no motion starts any more.
  auto* motion = motion_.get();
  if (motion && !stop_requested()) motion->start();
  if (motion && motion_.joint_owner().empty()) progress(events::NoPath{motion_.settings().enable});
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
  samples_.recorder()->end_operation(bus_.clock().now());
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
  if (!settings_.duration_s && motion_.get() && motion_.get()->done()) return false;
  tell_progress();
  return true;
}

void LineRun::tell_progress() {
  if (seconds_in_operation() < next_progress_s_) return;
  next_progress_s_ += bus_.virtual_time() ? 10.0 : 1.0;
  progress(motion_.get() ? motion_.get()->progress() : events::Progress{});
}

void LineRun::note(EventFacts facts, Severity severity) {
  Event event{std::move(facts), severity, {}};
  if (operating_ || severity != Severity::kProgress) event.time = operation_time_;
  settings_.observer->event(event);
  if (event.is_fault()) {
    if (auto* feed = samples_.feed()) feed->add_fault(describe(event, config_.output.increments));
    if (fault_records_) fault_records_->note_fault();
  }
  // Normal progress is not published, except that a state has been reached.
  auto* telemetry = telemetry_.service();
  if (telemetry && (severity != Severity::kProgress || event.is<events::StateReached>()))
    telemetry->tell(severity, describe(event, config_.output.increments));
  if (severity == Severity::kProgress) return;
  worst_ = std::max(worst_, severity);
  events_.add(std::move(event));
}

void LineRun::stop_motion() {
  auto* motion = motion_.get();
  if (!motion) return;
  note_requests();
  note_groups();
  if (auto* stream = motion_.stream()) stream->close();
  if (commands_) commands_->end_streams();
  if (!had(Severity::kFailure)) {
    motion->judge([this](EventFacts facts, Severity severity) { note(std::move(facts), severity); });
  }
  // Without a slave there is no receiver of a stop.
  if (!bus_.answers()) return;
  motion->request_stop();
  const auto deadline = bus_.clock().now() + kStopTimeout;
  do {
    pass(kWatchInterval);
    note_streams();
    note_requests();
  } while (!motion->off() && bus_.clock().now() < deadline);
  if (!motion->off()) fail_with(events::AxesNotOff{kStopTimeout});
}

void LineRun::take_down() {
  axis_requests().close();
  bus_.stop_services();
  if (auto* feed = samples_.feed()) feed->set_state(snapshot::LineState::kDown);
  const bool down = bus_.take_down();
  if (commands_) commands_->attach(nullptr);
  if (down) {
    progress(events::StateReached{bus_.state(), false});
    tell_slaves(true);
  }
  samples_.stop();
  note_telemetry();
  judge_axes();
  judge_tasks();
  const auto& recorder = *samples_.recorder();
  if (recorder.problem()) fail_with(events::FileNotWritten{*recorder.problem()});
  if (const auto begin = recorder.begins_at_s())
    note(events::RecordingShortened{*begin, recorder.rows()}, Severity::kNotice);
  if (operation_time_ > nanoseconds{0}) finish_fault_records();
}

/// Reports forbidden calls of tasks, which only a debug build counts.
void LineRun::judge_tasks() {
  for (const auto& task : motion_.settings().tasks->report()) {
    if (const auto calls = task.figures.forbidden_calls; calls > 0) fail_with(events::ForbiddenCalls{task.name, calls});
  }
}

}  // namespace driveline::runtime
