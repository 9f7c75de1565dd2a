#include "driveline/motion/cycle/cycle_runner.hpp"

namespace driveline::motion {
namespace {

using std::chrono::nanoseconds;

/// Periods before the first cycle, for the first wake-up.
constexpr int kPeriodsAhead = 4;

}  // namespace

RealtimeRunner::RealtimeRunner(Cycle& cycle, rt::Clock& clock, rt::RealtimeConfig config,
                               std::optional<nanoseconds> wake_ahead, nanoseconds early)
    : cycle_(cycle), clock_(clock), config_(std::move(config)), timer_(clock, cycle.period(), wake_ahead, early) {}

RealtimeRunner::~RealtimeRunner() {
  stop();
}

tl::expected<void, rt::RealtimeError> RealtimeRunner::start() {
  auto report = thread_.start(config_, *this);
  if (!report) return tl::unexpected(std::move(report.error()));
  report_ = std::move(*report);
  return {};
}

void RealtimeRunner::run(std::stop_token stop) noexcept {
  const auto before = rt::ThreadUsage::now();
  timer_.start(cycle_.first_grid(clock_.now() + kPeriodsAhead * timer_.period()));
  while (!stop.stop_requested()) {
    timer_.sleep_ahead();
    cycle_.prepare();
    cycle_.cycle(timer_.wait_next());
    timer_.shift_phase(cycle_.grid_shift());
  }
  usage_ = rt::ThreadUsage::now().since(before);
}

void RealtimeRunner::pass(nanoseconds duration) {
  clock_.sleep_until(clock_.now() + duration);
}

void RealtimeRunner::stop() {
  thread_.request_stop();
  thread_.join();
}

InlineRunner::InlineRunner(Cycle& cycle, rt::Clock& clock)
    : cycle_(cycle), clock_(clock), timer_(clock, cycle.period()) {}

tl::expected<void, rt::RealtimeError> InlineRunner::start() {
  timer_.start(cycle_.first_grid(clock_.now() + kPeriodsAhead * timer_.period()));
  return {};
}

void InlineRunner::pass(nanoseconds duration) {
  const auto end = clock_.now() + duration;
  do {
    cycle_.cycle(timer_.wait_next());
    timer_.shift_phase(cycle_.grid_shift());
  } while (clock_.now() < end);
}

}  // namespace driveline::motion
