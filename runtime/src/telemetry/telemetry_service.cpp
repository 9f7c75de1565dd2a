#include "telemetry/telemetry_service.hpp"

#include <algorithm>
#include <iterator>
#include <thread>
#include <utility>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/helper/helper_program.hpp"
#include "telemetry/line_feed.hpp"

namespace driveline::runtime {
namespace {

/// Time of the cycles in a batch, after which the bridge is woken.
constexpr std::chrono::milliseconds kWakePeriod{1};
/// Interval between two checks of the bridge.
constexpr std::chrono::milliseconds kLookPeriod{10};
/// On virtual time, time-out for a bridge that makes no progress.
constexpr std::chrono::milliseconds kBridgeTimeout{200};
/// More than the feed holds, so that even in a burst the newest events are available.
constexpr std::size_t kMaxWaitingEvents = 4 * snapshot::kFeedEvents;

}  // namespace

Result<std::filesystem::path> TelemetryService::find_program() {
  return find_helper_program("driveline-bridge", "DRIVELINE_BRIDGE");
}

TelemetryService::TelemetryService(const LineConfig& config, snapshot::FeedWriter feed, bool virtual_time)
    : feed_(std::move(feed)),
      assembler_(config.axes.size(), [this](const snapshot::FeedLine& line,
                                            std::span<const snapshot::FeedAxisSample> axes) { push(line, axes); }),
      waits_(virtual_time),
      cycles_per_wake_(std::max<std::uint64_t>(static_cast<std::uint64_t>(kWakePeriod / config.period), 1)) {}

Result<std::unique_ptr<TelemetryService>> TelemetryService::start(const LineConfig& config, bool virtual_time,
                                                                  BridgeSupervisor::Settings settings) {
  auto description = describe_for_feed(config);
  if (!description) return tl::unexpected(description.error());
  description->virtual_time = virtual_time ? 1 : 0;
  auto feed = snapshot::FeedWriter::create(*description, feed_cycles(config));
  if (!feed) return fail(ErrorKind::kMachine, rt::describe(feed.error()), "telemetry");
  std::unique_ptr<TelemetryService> service(new TelemetryService(config, *std::move(feed), virtual_time));
  auto supervisor = BridgeSupervisor::create(service->feed_, std::move(settings));
  if (!supervisor) return tl::unexpected(supervisor.error());
  service->supervisor_ = *std::move(supervisor);
  if (auto started = service->supervisor_->start(); !started) return tl::unexpected(started.error());
  return service;
}

void TelemetryService::push(const snapshot::FeedLine& line, std::span<const snapshot::FeedAxisSample> axes) {
  if (waits_) wait_for_bridge();
  feed_.push(line, axes);
  batch_ = (line.cycle + 1) / cycles_per_wake_;
}

/// Wakes the bridge when a batch is complete; the bridge then publishes it and needs no more frequent polling.
void TelemetryService::wake_bridge() {
  if (std::exchange(batch_of_wake_, batch_) != batch_) feed_.wake();
}

/// Waits until half of the feed is free. Does not wait for a bridge that has stopped, until it makes progress again.
void TelemetryService::wait_for_bridge() {
  const auto& counts = supervisor_->counts();
  const auto behind = [&] { return feed_.written() - counts.next() >= feed_.capacity() / 2; };
  if (!behind() || !supervisor_->running()) return;
  auto limit = Clock::now() + kBridgeTimeout;
  for (auto seen = counts.next(); behind() && supervisor_->running() && seen != stuck_at_;) {
    std::this_thread::sleep_for(std::chrono::microseconds{200});
    const auto now = Clock::now();
    supervisor_->serve(now);
    if (counts.next() != seen) limit = now + kBridgeTimeout;
    seen = counts.next();
    if (now > limit) stuck_at_ = seen;
  }
}

void TelemetryService::lines(std::span<const snapshot::LineSample> samples) {
  for (const auto& sample : samples) assembler_.add(sample);
}

void TelemetryService::axes(std::span<const snapshot::AxisSample> samples) {
  for (const auto& sample : samples) assembler_.add(sample);
}

void TelemetryService::set_line_status(const snapshot::LineStatus& status) {
  set_status(status_, status);
  tell_status();
}

void TelemetryService::tell_status() {
  status_.restarts = static_cast<std::uint32_t>(supervisor_->restarts());
  status_.published_before = supervisor_->counts().published_before();
  status_.dropped_before = supervisor_->counts().dropped_before() + dropped_by_rings_;
  ++status_.beats;
  feed_.set_status(status_);
}

void TelemetryService::pass_done(const snapshot::DrainCounters& counters) {
  wake_bridge();
  const auto now = Clock::now();
  if (now < next_look_) return;
  next_look_ = now + kLookPeriod;
  dropped_by_rings_ = counters.lines_dropped + counters.axes_dropped;
  tell_events();
  tell_condition();
  const auto restarts = supervisor_->restarts();
  supervisor_->serve(now);
  if (supervisor_->restarts() != restarts) tell_status();
  hand_over(counters);
}

void TelemetryService::finish(const snapshot::DrainCounters& counters) {
  assembler_.finish();
  tell_events();
  tell_condition();
  dropped_by_rings_ = counters.lines_dropped + counters.axes_dropped;
  status_.ended = 1;
  tell_status();
  feed_.wake();
  supervisor_->end();
  hand_over(counters);
}

void TelemetryService::tell(Severity severity, std::string_view sentence) {
  snapshot::FeedEvent event;
  event.wall_time_ns =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  event.severity = static_cast<std::uint64_t>(severity);
  event.text.set(sentence);
  const std::lock_guard lock(mutex_);
  if (waiting_events_.size() < kMaxWaitingEvents) waiting_events_.push_back(event);
}

void TelemetryService::tell_events() {
  std::vector<snapshot::FeedEvent> events;
  {
    const std::lock_guard lock(mutex_);
    events.swap(waiting_events_);
  }
  for (const auto& event : events) feed_.push_event(event);
}

void TelemetryService::set_condition(const snapshot::FeedCondition& condition) {
  const std::lock_guard lock(mutex_);
  condition_ = condition;
}

void TelemetryService::tell_condition() {
  std::optional<snapshot::FeedCondition> condition;
  {
    const std::lock_guard lock(mutex_);
    condition.swap(condition_);
  }
  if (condition) feed_.set_condition(*condition);
}

void TelemetryService::hand_over(const snapshot::DrainCounters& counters) {
  auto events = supervisor_->take_events();
  const std::lock_guard lock(mutex_);
  std::move(events.begin(), events.end(), std::back_inserter(events_));
  report_.published = supervisor_->counts().published();
  report_.dropped = counters.lines_dropped + counters.axes_dropped + supervisor_->counts().dropped();
  report_.restarts = supervisor_->restarts();
  report_.invalid_counts = supervisor_->invalid_counts();
}

std::vector<EventFacts> TelemetryService::poll() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

TelemetryReport TelemetryService::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

}  // namespace driveline::runtime
