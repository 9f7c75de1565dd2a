// Does a line run for hours as well as in its first minute? Records wake-up latency, cycle cost, missed periods and
// memory in windows of time, and compares the last third of them with the first.
#include <fmt/format.h>
#include <sys/resource.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "support/delay_histogram.hpp"
#include "support/environment.hpp"
#include "support/line_rig.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr std::size_t kAxes = 8;
constexpr double kSeconds = 600.0;
constexpr double kSecondsInShort = 30.0;
constexpr double kPeriodUs = 125.0;
/// Independent of the duration, so that the memory of this program is, too.
constexpr int kWindows = 60;
constexpr auto kPath = 2s;
constexpr double kMib = 1024.0 * 1024.0;

/// The measurements of a window.
struct Window {
  DelayHistogram wake{kPeriodUs};
  DelayHistogram cost{kPeriodUs};
  std::int64_t missed = 0;                ///< missed periods
  std::int64_t page_faults = 0;           ///< since the start of the thread of the cycle
  std::int64_t involuntary_switches = 0;  ///< since the start of the thread of the cycle

  void reset() noexcept {
    wake.reset();
    cost.reset();
    missed = 0;
  }
};

/// The cycle of 125 us as in `run`. Records into one of two windows while the caller reads the other one.
class Cycling final : public motion::CycleRunner, private rt::RealtimeTask {
 public:
  Cycling(ecat_master::CyclicCore& core, rt::Clock& clock, LineRig& rig)
      : core_(core), clock_(clock), rig_(rig), timer_(clock, LineRig::kPeriod, std::nullopt) {}
  ~Cycling() override { stop(); }

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override {
    start_realtime(thread_, *this);
    return {};
  }
  void pass(nanoseconds duration) override {
    clock_.sleep_until(clock_.now() + duration);
    rig_.drain();
  }
  void stop() override {
    thread_.request_stop();
    thread_.join();
  }

  /// Starts a new window and returns the previous one, which is valid until the next call. Throws Disturbed if the
  /// cycle has stopped.
  const Window& turn_over() {
    const int before = noted_in_.load(std::memory_order_relaxed);
    windows_[static_cast<std::size_t>(1 - before)].reset();
    note_in_.store(1 - before, std::memory_order_release);
    const auto patience = clock_.now() + 10s;
    while (noted_in_.load(std::memory_order_acquire) == before) {
      if (clock_.now() > patience) throw Disturbed("the cycle has stood still for ten seconds");
      pass(1ms);
    }
    return windows_[static_cast<std::size_t>(before)];
  }

 private:
  void run(std::stop_token stop) noexcept override {
    timer_.start((clock_.now() / LineRig::kPeriod + 4) * LineRig::kPeriod);
    while (!stop.stop_requested()) {
      const auto start = timer_.wait_next();
      const double begin = now_ns();
      core_.cycle(start);
      note(start, now_ns() - begin);
    }
  }
  void note(const rt::CycleStart& start, double cost_ns) noexcept {
    const int before = noted_in_.load(std::memory_order_relaxed);
    const int now = note_in_.load(std::memory_order_acquire);
    if (now != before) {
      rusage usage{};
      getrusage(RUSAGE_THREAD, &usage);
      auto& ended = windows_[static_cast<std::size_t>(before)];
      ended.page_faults = usage.ru_minflt + usage.ru_majflt;
      ended.involuntary_switches = usage.ru_nivcsw;
      noted_in_.store(now, std::memory_order_release);
    }
    auto& window = windows_[static_cast<std::size_t>(now)];
    window.wake.add_late(start.late(LineRig::kPeriod), start.missed, LineRig::kPeriod);
    window.cost.add(nanoseconds{static_cast<std::int64_t>(cost_ns)});
    window.missed += start.missed;
  }

  ecat_master::CyclicCore& core_;
  rt::Clock& clock_;
  LineRig& rig_;
  rt::CycleTimer timer_;
  rt::RealtimeThread thread_;
  std::array<Window, 2> windows_;
  std::atomic<int> note_in_{0};   ///< window requested by the caller
  std::atomic<int> noted_in_{0};  ///< window used by the cycle
};

/// The whole measurement, and its course over time.
struct Soak {
  DelayHistogram wake{kPeriodUs};
  DelayHistogram cost{kPeriodUs};
  Course wake_course;
  Course cost_course;
  Course memory_course;  ///< in MiB
  Course missed_course;
  std::int64_t missed = 0;
  std::int64_t page_faults = 0;
  std::int64_t involuntary_switches = 0;
};

void extend(Course& course, const Summary& figures) {
  course.p50.push_back(figures.p50);
  course.p99.push_back(figures.p99);
  course.max.push_back(figures.max);
}

Summary just(double value, std::size_t n = 1) {
  return {n, value, value, value, value};
}

void take(Soak& soak, const Window& window, double mib) {
  soak.wake.merge(window.wake);
  soak.cost.merge(window.cost);
  extend(soak.wake_course, window.wake.summary());
  extend(soak.cost_course, window.cost.summary());
  extend(soak.memory_course, just(mib));
  extend(soak.missed_course, just(static_cast<double>(window.missed)));
  soak.missed += window.missed;
}

void tell(double passed_s, double seconds, const Window& window, double mib) {
  const auto wake = window.wake.summary();
  const auto cost = window.cost.summary();
  fmt::print(stderr,
             "soak: {:.0f} of {:.0f} s: wake-up p50 {:.2f} us, p99 {:.2f} us, max {:.1f} us; cycle p50 {:.2f} us, max "
             "{:.1f} us; {} periods missed; {:.1f} MiB\n",
             passed_s, seconds, wake.p50 / 1e3, wake.p99 / 1e3, wake.max / 1e3, cost.p50 / 1e3, cost.max / 1e3,
             window.missed, mib);
}

/// Runs for `seconds`, and prints a line per window.
std::unique_ptr<Soak> soak_for(double seconds) {
  rt::MonotonicClock clock;
  LineRig rig(clock, kAxes, kPath);
  Cycling* cycling = nullptr;
  rig.bring_up([&](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
    auto runner = std::make_unique<Cycling>(core, clock, rig);
    cycling = runner.get();
    return runner;
  });
  // At the end of their path the axes hold their positions for any time.
  while (rig.motion().phase() == motion::MotionPhase::kFollowing) rig.master().pass(10ms);
  auto soak = std::make_unique<Soak>();
  const auto first = cycling->turn_over();
  const double window_s = seconds / kWindows;
  for (auto* course : {&soak->wake_course, &soak->cost_course, &soak->memory_course, &soak->missed_course})
    course->window_s = window_s;
  const auto begin = clock.now();
  for (int i = 1; i <= kWindows; ++i) {
    const auto end = begin + nanoseconds{static_cast<std::int64_t>(window_s * 1e9 * i)};
    while (clock.now() < end) rig.master().pass(std::min<nanoseconds>(5ms, end - clock.now()));
    const auto& window = cycling->turn_over();
    const double mib = static_cast<double>(resident_bytes()) / kMib;
    take(*soak, window, mib);
    soak->page_faults = window.page_faults - first.page_faults;
    soak->involuntary_switches = window.involuntary_switches - first.involuntary_switches;
    tell(window_s * i, seconds, window, mib);
    if (rig.motion().phase() != motion::MotionPhase::kHolding) {
      throw Disturbed(fmt::format("the axes did not hold their positions after {:.0f} s: {}", window_s * i,
                                  to_text(rig.motion().phase())));
    }
  }
  cycling->stop();
  return soak;
}

/// Reports the drift of a course: the last third of its windows compared with the first.
void report_drift(Report& report, const char* metric, const char* unit, const std::vector<double>& course) {
  const auto third = course.size() / 3;
  const std::vector<double> first(course.begin(), course.begin() + static_cast<std::ptrdiff_t>(third));
  const std::vector<double> last(course.end() - static_cast<std::ptrdiff_t>(third), course.end());
  report.add({fmt::format("{}_axes", kAxes), fmt::format("{}_in_last_third", metric), unit, summarize(last),
              std::nullopt, Baseline{"first_third", summarize(first), ratios_by_turn(last, first)}});
}

void measure_all(const Options& options) {
  Report report("soak");
  const double seconds = options.duration(kSeconds, kSecondsInShort);
  claim_cpu(std::max(0, last_cpu() - 1));
  const auto soak = soak_for(seconds);
  const auto name = fmt::format("{}_axes", kAxes);
  const auto cycles = static_cast<std::size_t>(soak->cost.count());
  const auto with_course = [&](const char* metric, const char* unit, const Summary& figures, const Course& course,
                               const std::optional<DelayHistogram>& delays) {
    report.add({name, metric, unit, figures, std::nullopt, std::nullopt, std::nullopt, delays, course});
  };
  with_course("wake_latency", "ns", soak->wake.summary(), soak->wake_course, soak->wake);
  with_course("whole_cycle", "ns", soak->cost.summary(), soak->cost_course, soak->cost);
  with_course("missed_periods", "1", just(static_cast<double>(soak->missed), cycles), soak->missed_course, {});
  with_course("resident_memory", "MiB", summarize(soak->memory_course.p50), soak->memory_course, {});
  report_drift(report, "wake_latency_p50", "ns", soak->wake_course.p50);
  report_drift(report, "wake_latency_p99", "ns", soak->wake_course.p99);
  report_drift(report, "wake_latency_max", "ns", soak->wake_course.max);
  report_drift(report, "whole_cycle_p50", "ns", soak->cost_course.p50);
  report_drift(report, "whole_cycle_p99", "ns", soak->cost_course.p99);
  report_drift(report, "whole_cycle_max", "ns", soak->cost_course.max);
  report_drift(report, "missed_periods", "1", soak->missed_course.p50);
  report_drift(report, "resident_memory", "MiB", soak->memory_course.p50);
  report.add({name, "page_faults", "1", just(static_cast<double>(soak->page_faults), cycles), 0.0});
  report.add({name, "involuntary_switches", "1", just(static_cast<double>(soak->involuntary_switches), cycles)});
  report.note(fmt::format(
      "{} axes that hold, enabled, on a line in the same process, every 125 us for {:.0f} s; {} windows, of which the\n"
      "last third is compared with the first. whole_cycle includes the simulated drives.",
      kAxes, seconds, kWindows));
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "Does a line run for hours as well as in its first minute?", measure_all);
}
