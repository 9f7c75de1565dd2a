// How many periods does `driveline run` miss on an idle machine? Compared by turns with a bare loop that is awake as
// long in each period, and with cyclictest, which sleeps nearly all the time. The host of a virtual machine takes the
// processor away at any time, and the longer a thread is awake, the more of it falls into its work: the loop is the
// fair comparison.
#include <fmt/format.h>
#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <ctime>
#include <optional>
#include <stop_token>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/realtime_thread.hpp"
#include "driveline/rt/time_conversion.hpp"
#include "support/cyclictest.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/samples.hpp"
#include "support/telemetry_run.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr std::size_t kAxes = 8;
constexpr std::chrono::microseconds kPeriod{125};
constexpr std::chrono::milliseconds kTurn{8000};
constexpr std::chrono::milliseconds kQuickTurn{1000};
constexpr int kTurns = 10;
constexpr int kTurnsInShort = 4;

/// A bare loop of clock_nanosleep that is awake from `ahead` before each instant until `busy` after it, and counts the
/// instants that it missed.
class AwakeLoop final : public rt::RealtimeTask {
 public:
  AwakeLoop(nanoseconds ahead, nanoseconds busy, int cycles) : ahead_(ahead), busy_(busy), cycles_(cycles) {}

  void run(std::stop_token /*stop*/) noexcept override {
    auto next = clock_.now() + 4 * kPeriod;
    for (int i = 0; i < cycles_; ++i) {
      const auto until = rt::to_timespec(next - ahead_);
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
      }
      const auto late = std::max(clock_.spin_until(next) - next, nanoseconds{0});
      missed_ += late / kPeriod;
      next += late / kPeriod * kPeriod;
      clock_.spin_until(next + busy_);
      // Work that ends after the next instant has missed that one, as in a cycle.
      next += kPeriod;
    }
  }
  [[nodiscard]] std::int64_t missed() const noexcept { return missed_; }

 private:
  rt::MonotonicClock clock_;
  nanoseconds ahead_;
  nanoseconds busy_;
  int cycles_;
  std::int64_t missed_ = 0;
};

double missed_by_loop(nanoseconds busy, int cycles) {
  AwakeLoop loop(kWakeAhead, busy, cycles);
  rt::RealtimeThread thread;
  start_realtime(thread, loop);
  thread.join();
  return static_cast<double>(loop.missed());
}

/// None: cyclictest is not installed.
std::optional<double> missed_by_cyclictest(int cycles) {
  const auto latencies_ns = run_cyclictest(
      {.period = kPeriod, .cpu = last_cpu(), .priority = rt::RealtimeConfig{}.priority.value(), .loops = cycles});
  if (!latencies_ns) return std::nullopt;
  double missed = 0.0;
  for (const double latency_ns : *latencies_ns) {
    missed += static_cast<double>(nanoseconds{static_cast<std::int64_t>(latency_ns)} / kPeriod);
  }
  return missed;
}

/// Missed periods in each turn.
struct Missed {
  std::vector<double> run{};
  std::vector<double> loop{};
  std::vector<double> cyclictest{};
  std::vector<double> awake_us{};  ///< time for which `run` is awake in a period
};

Missed take_turns(int turns, std::chrono::milliseconds turn) {
  const auto cycles = static_cast<int>(turn / kPeriod);
  TelemetryRuns runs;
  Missed missed;
  bool with_cyclictest = true;
  for (int i = 0; i < turns; ++i) {
    const auto run = undisturbed("run", [&] {
      return runs.measure({.axes = kAxes, .telemetry = false, .reader = {}, .duration = turn, .stall = false});
    });
    missed.run.push_back(run.missed_periods);
    const auto busy = nanoseconds{static_cast<std::int64_t>(run.cycle_cost_p50_us * 1e3)};
    missed.awake_us.push_back(static_cast<double>((kWakeAhead + busy).count()) / 1e3);
    missed.loop.push_back(missed_by_loop(busy, cycles));
    const auto peer = with_cyclictest ? missed_by_cyclictest(cycles) : std::nullopt;
    with_cyclictest = peer.has_value();
    if (peer) missed.cyclictest.push_back(*peer);
  }
  return missed;
}

void measure_all(const Options& options) {
  Report report("missed");
  const auto missed = take_turns(options.quick     ? 1
                                 : options.shorter ? kTurnsInShort
                                                   : kTurns,
                                 options.quick ? kQuickTurn : kTurn);
  const auto loop = summarize(missed.loop);
  const auto against = [&](const char* name, const std::vector<double>& floor) {
    Baseline baseline{name, summarize(floor)};
    for (std::size_t i = 0; i < floor.size(); ++i) baseline.ratios.add(missed.run[i], floor[i]);
    return baseline;
  };
  report.add({"run_8_axes", "missed_periods", "1", summarize(missed.run), std::nullopt,
              against("bare_loop_as_long_awake", missed.loop)});
  report.add({"bare_loop_as_long_awake", "missed_periods", "1", loop});
  report.add({"run_8_axes", "awake_per_period", "us", summarize(missed.awake_us)});
  if (!missed.cyclictest.empty()) {
    report.add({"run_8_axes", "missed_periods_over_cyclictest", "1", summarize(missed.run), std::nullopt,
                against("cyclictest", missed.cyclictest)});
    report.add({"cyclictest", "missed_periods", "1", summarize(missed.cyclictest)});
  }
  report.note(fmt::format(
      "Missed periods of 125 us in turns of {} s on one processor, idle. The loop is awake in each period as long as\n"
      "`run` was in the turn before it: from {} us ahead until the median of the cost after the instant.",
      std::chrono::duration<double>(options.quick ? kQuickTurn : kTurn).count(), kWakeAhead.count()));
  report.print(options);
  if (missed.cyclictest.empty()) throw Skipped("no comparison with cyclictest: it is not installed (Debian: rt-tests)");
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "How many periods does `driveline run` miss, against a loop that is awake as long?",
             measure_all);
}
