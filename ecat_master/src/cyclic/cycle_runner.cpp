#include "driveline/ecat_master/cyclic/cycle_runner.hpp"

namespace driveline::ecat_master {
namespace {

using std::chrono::nanoseconds;

/// First grid time: the next multiple of the period on the clock, a few periods ahead. Drives without distributed
/// clocks run their control loops on such multiples as well when they share the clock, so the phase between frames and
/// control loops is the same at every start.
nanoseconds first_grid_time(const rt::Clock& clock, nanoseconds period) noexcept {
  constexpr int kPeriodsAhead = 4;
  return (clock.now() / period + kPeriodsAhead) * period;
}

}  // namespace

RealtimeRunner::RealtimeRunner(CyclicCore& core, rt::Clock& clock, rt::RealtimeConfig config, nanoseconds wake_ahead)
    : core_(core), clock_(clock), config_(std::move(config)), timer_(clock, core.settings().period, wake_ahead) {}

RealtimeRunner::~RealtimeRunner() {
  stop();
}

tl::expected<void, std::string> RealtimeRunner::start() {
  auto report = thread_.start(config_, *this);
  if (!report) return tl::unexpected(report.error().message());
  report_ = std::move(*report);
  return {};
}

void RealtimeRunner::run(std::stop_token stop) noexcept {
  timer_.start(first_grid_time(clock_, timer_.period()));
  while (!stop.stop_requested()) core_.cycle(timer_.wait_next());
}

void RealtimeRunner::pass(nanoseconds duration) {
  clock_.sleep_until(clock_.now() + duration);
}

void RealtimeRunner::stop() {
  thread_.request_stop();
  thread_.join();
}

InlineRunner::InlineRunner(CyclicCore& core, rt::Clock& clock)
    : core_(core), clock_(clock), timer_(clock, core.settings().period) {}

tl::expected<void, std::string> InlineRunner::start() {
  timer_.start(first_grid_time(clock_, timer_.period()));
  return {};
}

void InlineRunner::pass(nanoseconds duration) {
  const auto end = clock_.now() + duration;
  do {
    core_.cycle(timer_.wait_next());
  } while (clock_.now() < end);
}

}  // namespace driveline::ecat_master
