// Do readers of the telemetry receive every cycle at 8 kHz, and what does telemetry cost the cycle?
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "driveline/motion/cycle/sample_rings.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "support/line_rig.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/samples.hpp"
#include "support/stopwatch.hpp"
#include "support/telemetry_run.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;

constexpr int kPairs = 10;
constexpr int kPairsInShort = 2;
constexpr double kPercent = 0.01;
constexpr double kCostAim = 105.0;        // %, upper end of the interval
constexpr double kLatencyAimUs = 2000.0;  // p99, with batches of a millisecond
constexpr double kBridgeAimMib = 128.0;
constexpr double kRunAimMib = 48.0;  // for 8 axes
constexpr double kSampleAimNs = 20.0;
constexpr std::size_t kFewAxes = 8;

struct Pair {
  TelemetryFigures without;
  TelemetryFigures with;
};

int pairs_of(const Options& options) {
  return options.quick || options.shorter ? kPairsInShort : kPairs;
}

/// A summary with the same value for all percentiles.
Summary just(double value, std::size_t n) {
  return {n, value, value, value, value};
}

using Figure = std::function<double(const TelemetryFigures&)>;

std::vector<double> each(const std::vector<Pair>& pairs, const Figure& figure) {
  std::vector<double> values;
  for (const auto& pair : pairs) values.push_back(figure(pair.with));
  return values;
}

std::vector<double> ratios(const std::vector<Pair>& pairs, const Figure& figure) {
  std::vector<double> values;
  for (const auto& pair : pairs) values.push_back(figure(pair.with) / figure(pair.without));
  return values;
}

/// Reports the ratio of a cost with telemetry over the one without: the ratios of all pairs, and the upper end of their
/// 95 % interval, which has the aim.
void add_ratio(Report& report, const std::string& name, const char* what, const std::vector<double>& values,
               std::optional<double> aim) {
  report.add({name, fmt::format("{}_p999_with_over_without", what), "%", divided(summarize(values), kPercent)});
  report.add({name, fmt::format("{}_p999_upper_end_of_95_interval", what), "%",
              just(upper_95(values) / kPercent, values.size()), aim});
}

void add_costs(Report& report, const std::string& name, const std::vector<Pair>& pairs, std::optional<double> aim) {
  add_ratio(report, name, "cycle_cost", ratios(pairs, [](const auto& run) { return run.cycle_cost_p999_us; }), aim);
  add_ratio(report, name, "wake_latency", ratios(pairs, [](const auto& run) { return run.wake_latency_p999_us; }),
            std::nullopt);
  std::vector<double> missed_with;
  std::vector<double> missed_without;
  for (const auto& pair : pairs) {
    missed_with.push_back(pair.with.missed_periods);
    missed_without.push_back(pair.without.missed_periods);
  }
  report.add({name, "missed_periods_with", "1", summarize(missed_with)});
  report.add({name, "missed_periods_without", "1", summarize(missed_without)});
  report.add({name, "missed_periods_more_lower_end_of_95_interval", "1",
              just(mean_difference_95(missed_with, missed_without).low, pairs.size()), 0.0});
}

void add_received(Report& report, const std::string& name, const std::vector<Pair>& pairs) {
  const auto add = [&](const char* metric, const char* unit, const Figure& figure, std::optional<double> aim = {}) {
    report.add({name, metric, unit, summarize(each(pairs, figure)), aim});
  };
  double lost = 0.0;
  double skipped = 0.0;
  double longest = 0.0;
  for (const auto& [without, with] : pairs) {
    lost += with.dropped + with.received->lost_batches;
    skipped += with.received->skipped_cycles;
    longest = std::max(longest, with.received->latency_us[3]);
  }
  report.add({name, "samples_and_batches_lost", "1", just(lost, pairs.size()), 0.0});
  report.add({name, "cycles_skipped", "1", just(skipped, pairs.size()), 0.0});
  add("cycles_received", "1", [](const auto& run) { return run.received->cycles; });
  add("latency_p50", "us", [](const auto& run) { return run.received->latency_us[0]; });
  add(
      "latency_p99", "us", [](const auto& run) { return run.received->latency_us[1]; }, kLatencyAimUs);
  add("latency_p999", "us", [](const auto& run) { return run.received->latency_us[2]; });
  report.add({name, "latency_max", "us", just(longest, pairs.size())});
  add("bridge_cpu", "%", [](const auto& run) { return run.bridge_cpu_share / kPercent; });
  add("reader_cpu", "%", [](const auto& run) { return run.received->cpu_share / kPercent; });
}

/// Alternates runs with and without; the order alternates, too.
std::vector<Pair> measure_pairs(Report& report, TelemetryRuns& runs, const std::string& name, const TelemetryPlan& with,
                                const TelemetryPlan& without, int count) {
  std::vector<Pair> pairs;
  int repeated = 0;
  for (int i = 0; i < count; ++i) {
    undisturbed(
        name,
        [&] {
          Pair pair;
          if (i % 2 == 0) pair.without = runs.measure(without);
          pair.with = runs.measure(with);
          if (i % 2 != 0) pair.without = runs.measure(without);
          if (pair.with.received && pair.with.received->cycles < 1.0) {
            throw Disturbed("the reader has received nothing: it has found the bridge too late");
          }
          pairs.push_back(std::move(pair));
        },
        &repeated);
    fmt::print(stderr, "{}: {} of {} pairs\n", name, i + 1, count);
  }
  // Runs that failed because the machine was busy are missing in all other figures.
  report.add({name, "pairs_repeated", "1", just(repeated, pairs.size())});
  return pairs;
}

const char* text(TelemetryReader reader) {
  return reader == TelemetryReader::kFastDds ? "fast_dds" : "cyclone";
}

void measure_reader(Report& report, TelemetryRuns& runs, std::size_t axes, TelemetryReader reader,
                    const Options& options) {
  const auto name = fmt::format("{}_axes_{}", axes, text(reader));
  const TelemetryPlan with{.axes = axes, .reader = reader, .duration = options.quick ? 1000ms : 2000ms};
  auto without = with;
  without.telemetry = false;
  without.reader.reset();
  const auto pairs = measure_pairs(report, runs, name, with, without, pairs_of(options));
  add_received(report, name, pairs);
  add_costs(report, name, pairs, kCostAim);
  const auto memory = [&](const char* metric, const Figure& figure, std::optional<double> aim) {
    report.add({name, metric, "MiB", summarize(each(pairs, figure)), aim});
  };
  memory(
      "memory_of_the_bridge", [](const auto& run) { return run.bridge_mib; }, kBridgeAimMib);
  memory(
      "memory_of_the_run", [](const auto& run) { return run.run_mib; },
      axes == kFewAxes ? std::optional(kRunAimMib) : std::nullopt);
}

/// Stops the bridge for two seconds, with a reader, compared with a run without telemetry.
void measure_stall(Report& report, TelemetryRuns& runs, const Options& options) {
  const auto name = fmt::format("{}_axes_bridge_stopped", kFewAxes);
  const TelemetryPlan without{.axes = kFewAxes, .reader = TelemetryReader::kFastDds, .duration = 4000ms};
  auto with = without;
  with.stall = true;
  const auto pairs = measure_pairs(report, runs, name, with, without, pairs_of(options));
  for (const auto& pair : pairs) {
    if (pair.with.dropped < 1.0) throw std::runtime_error(name + ": nothing was dropped, so it was not stopped");
  }
  report.add({name, "samples_dropped", "1", summarize(each(pairs, [](const auto& run) { return run.dropped; }))});
  add_costs(report, name, pairs, kCostAim);
}

/// Runs cycles back to back in the caller's thread.
class Cycles final : public motion::CycleRunner {
 public:
  Cycles(ecat_master::CyclicCore& core, rt::Clock& clock, LineRig& rig)
      : core_(core), clock_(clock), rig_(rig), timer_(clock, LineRig::kPeriod) {}

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override { return {}; }
  void pass(std::chrono::nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      core_.cycle(timer_.wait_next());
      rig_.drain();
    } while (clock_.now() < end);
  }
  void stop() override {}

 private:
  ecat_master::CyclicCore& core_;
  rt::Clock& clock_;
  LineRig& rig_;
  rt::CycleTimer timer_;
};

/// Measures the telemetry part of the cycle: writing the samples of its axes, in OP.
void measure_samples(Report& report, const Options& options) {
  constexpr int kBatch = 64;
  for (const std::size_t axes : {8U, 32U}) {
    rt::VirtualClock clock;
    LineRig rig(clock, axes, 2s);
    rig.bring_up([&](ecat_master::CyclicCore& core) { return std::make_unique<Cycles>(core, clock, rig); });
    rt::SpscRing<snapshot::AxisSample> ring(kBatch * axes);
    std::vector<snapshot::AxisSample> taken(ring.capacity());
    const snapshot::LineSample line;
    std::vector<double> samples;
    for (int i = 0; i < options.count(20'000); ++i) {
      const double begin = now_ns();
      for (int k = 0; k < kBatch; ++k) motion::publish(rig.motion(), line, ring);
      samples.push_back((now_ns() - begin - reading_cost_ns()) / (kBatch * static_cast<double>(axes)));
      if (ring.pop(taken) != kBatch * axes) throw std::runtime_error("samples were dropped");
    }
    report.add({fmt::format("{}_axes", axes), "sample_per_axis", "ns", summarize(std::move(samples)), kSampleAimNs});
  }
}

void measure_all(const Options& options) {
  Report report("telemetry");
  measure_samples(report, options);
  TelemetryRuns runs;
  // Each run starts two programs more, so the quick form has the shorter line alone.
  const auto lines = options.quick ? std::vector{kFewAxes} : std::vector{kFewAxes, std::size_t{32}};
  for (const std::size_t axes : lines) {
    for (const auto reader : {TelemetryReader::kFastDds, TelemetryReader::kCyclone})
      measure_reader(report, runs, axes, reader, options);
  }
  measure_stall(report, runs, options);
  report.note(
      "Every run is `driveline run` on a simulated line, every 125 us, with its drives in the same process; the "
      "reader\n"
      "is another process on this machine and takes driveline/v1/axis_batch over UDP on the loopback interface. "
      "Latency:\n"
      "from the instant of a cycle until the reader has it, of which a batch takes up to a millisecond to be full.");
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv,
             "What do readers of the telemetry receive of every cycle at 8 kHz, and what does it cost the cycle?",
             measure_all);
}
