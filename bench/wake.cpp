// How late does a real-time thread wake up on a grid of 125 us, and which part of that is due to the cycle timer?
#include <fmt/format.h>
#include <cerrno>
#include <ctime>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/time_conversion.hpp"
#include "support/latency_histogram.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = 125us;
constexpr int kWakeUps = 40'000;
constexpr int kRounds = 10;
/// Wake-ups at the start of a stretch that do not count.
constexpr int kWarmUp = 20;

/// The baseline: clock_nanosleep to absolute times only. The latency counts from the requested instant.
void sleep_alone(rt::MonotonicClock& clock, int count, std::vector<double>& latencies_ns) noexcept {
  auto next = clock.now() + 4 * kPeriod;
  for (int i = -kWarmUp; i < count; ++i) {
    const auto until = rt::to_timespec(next);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
    const auto late = clock.now() - next;
    if (i >= 0) latencies_ns.push_back(static_cast<double>(late.count()));
    next += (late / kPeriod + 1) * kPeriod;
  }
}

/// The same with the cycle timer. Skipped periods are part of the latency of the wake-up that was late.
void cycle_timer(rt::MonotonicClock& clock, nanoseconds wake_ahead, int count,
                 std::vector<double>& latencies_ns) noexcept {
  rt::CycleTimer timer(clock, kPeriod, wake_ahead);
  timer.start(clock.now() + 4 * kPeriod);
  for (int i = -kWarmUp; i < count; ++i) {
    const auto start = timer.wait_next();
    const auto late = start.wake - start.grid + start.missed * kPeriod;
    if (i >= 0) latencies_ns.push_back(static_cast<double>(late.count()));
  }
}

/// Takes all methods of waiting in turns, so that a disturbance of the machine affects all alike.
class Waits final : public rt::RealtimeTask {
 public:
  explicit Waits(int wake_ups) : per_round_(wake_ups / kRounds) {
    for (auto* latencies : {&floor_ns, &timer_ns, &ahead_ns}) latencies->reserve(static_cast<std::size_t>(wake_ups));
  }
  void run(std::stop_token) noexcept override {
    for (int round = 0; round < kRounds; ++round) {
      sleep_alone(clock_, per_round_, floor_ns);
      cycle_timer(clock_, 0us, per_round_, timer_ns);
      cycle_timer(clock_, 25us, per_round_, ahead_ns);
    }
  }
  std::vector<double> floor_ns;
  std::vector<double> timer_ns;
  std::vector<double> ahead_ns;

 private:
  rt::MonotonicClock clock_;
  int per_round_;
};

void measure_all(const Options& options) {
  Waits waits(options.count(kWakeUps));
  rt::RealtimeThread thread;
  start_realtime(thread, waits);
  thread.join();
  if (!options.histogram.empty()) {
    // The waiting of the cycle of a line without `wake_ahead_us`.
    write_latency_histogram(options.histogram, "cycle_timer", waits.timer_ns);
  }
  Report report("wake");
  const Baseline floor{"clock_nanosleep_loop", summarize(std::move(waits.floor_ns))};
  report.add({"clock_nanosleep_loop", "wake_latency", "ns", floor.figures});
  report.add({"cycle_timer", "wake_latency", "ns", summarize(std::move(waits.timer_ns)), std::nullopt, floor});
  report.add(
      {"cycle_timer_25us_ahead", "wake_latency", "ns", summarize(std::move(waits.ahead_ns)), std::nullopt, floor});
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How late does a real-time thread wake up on a grid of 125 us?", measure_all);
}
