// Measures the cost of a whole cycle (receive, axes, interpolation, send, slaves, plant) and of the master's part
// alone.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <random>
#include <thread>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "support/line_rig.hpp"
#include "support/real_time_limit.hpp"
#include "support/realtime.hpp"
#include "support/report.hpp"
#include "support/retry.hpp"
#include "support/stopwatch.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using std::chrono::nanoseconds;

constexpr int kCycles = 40'000;
constexpr double kWholeAimUs = 40.0;    // for 32 axes
constexpr double kMasterAimNs = 150.0;  // per axis
constexpr std::size_t kWholeAimAxes = 32;
constexpr auto kWakeAhead = std::chrono::microseconds{25};

/// Runs cycles and measures each in one of two ways by chance: as a whole, without measuring inside, or without the
/// time inside the port. Turns of one cycle each would let frames leave early and late by turns, and a drive without a
/// synchronised clock, which looks for outputs at that instant, would find those of every second cycle only.
class CycleMeter {
 public:
  CycleMeter(ecat_master::CyclicCore& core, TimedPort& port, int cycles)
      : core_(core), port_(port), wanted_(static_cast<std::size_t>(cycles)) {
    whole_ns.reserve(wanted_);
    master_ns.reserve(wanted_);
  }

  void cycle(const rt::CycleStart& start) noexcept {
    if (!armed_.load(std::memory_order_acquire)) return core_.cycle(start);
    const bool inside = chance_() % 2 == 0;
    port_.reset(inside);
    const double begin = now_ns();
    core_.cycle(start);
    const double cost = now_ns() - begin - reading_cost_ns();
    if (inside) {
      master_ns.push_back(cost - port_.overhead_ns() - port_.inside_ns());
    } else {
      whole_ns.push_back(cost);
    }
    if (master_ns.size() < wanted_ / 2) return;
    port_.reset(false);
    armed_.store(false, std::memory_order_release);
  }

  /// Measures until there are enough samples. Any thread.
  void arm() noexcept { armed_.store(true, std::memory_order_release); }
  [[nodiscard]] bool done() const noexcept { return !armed_.load(std::memory_order_acquire); }

  std::vector<double> whole_ns;
  std::vector<double> master_ns;

 private:
  ecat_master::CyclicCore& core_;
  TimedPort& port_;
  std::size_t wanted_;
  std::mt19937 chance_{20261130};
  std::atomic<bool> armed_{false};
};

/// Runs cycles back to back on virtual time, in the caller's thread.
class BackToBackRunner final : public motion::CycleRunner {
 public:
  BackToBackRunner(CycleMeter& meter, rt::Clock& clock, LineRig& rig)
      : meter_(meter), clock_(clock), rig_(rig), timer_(clock, LineRig::kPeriod) {}

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override { return {}; }
  void pass(nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      meter_.cycle(timer_.wait_next());
      rig_.drain();
    } while (clock_.now() < end);
    rests_.take_when_due(now_ns());
  }
  void stop() override {}

 private:
  CycleMeter& meter_;
  rt::Clock& clock_;
  LineRig& rig_;
  rt::CycleTimer timer_;
  Rests rests_;
};

/// Runs a cycle every 125 us in a real-time thread that sleeps in between, while the caller's thread empties the rings.
class PacedRunner final : public motion::CycleRunner, private rt::RealtimeTask {
 public:
  PacedRunner(CycleMeter& meter, rt::Clock& clock, LineRig& rig)
      : meter_(meter), clock_(clock), rig_(rig), timer_(clock, LineRig::kPeriod, kWakeAhead) {}
  ~PacedRunner() override { stop(); }

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

 private:
  void run(std::stop_token stop) noexcept override {
    timer_.start((clock_.now() / LineRig::kPeriod + 4) * LineRig::kPeriod);
    while (!stop.stop_requested()) meter_.cycle(timer_.wait_next());
  }

  CycleMeter& meter_;
  rt::Clock& clock_;
  LineRig& rig_;
  rt::CycleTimer timer_;
  rt::RealtimeThread thread_;
};

struct Figures {
  Summary whole_ns;
  Summary master_ns;
  std::size_t image_bytes = 0;
};

/// Brings up a line with a runner of this type and measures it.
template <typename Runner>
Figures measure(rt::Clock& clock, std::size_t axes, int cycles) {
  // Skipped periods consume the path, so it is twice as long as needed.
  LineRig rig(clock, axes, 2 * cycles * LineRig::kPeriod + std::chrono::seconds{2});
  std::unique_ptr<CycleMeter> meter;
  rig.bring_up([&](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
    meter = std::make_unique<CycleMeter>(core, rig.port(), cycles);
    return std::make_unique<Runner>(*meter, clock, rig);
  });
  meter->arm();
  while (!meter->done()) rig.master().pass(std::chrono::milliseconds{5});
  rig.master().runner()->stop();
  rig.check();
  return {summarize(meter->whole_ns), summarize(meter->master_ns), rig.master().image().outputs().size()};
}

/// The baseline: copies outputs into a frame and inputs out of it. ns per cycle.
Baseline copy_process_image(std::size_t bytes, int count) {
  constexpr int kBatch = 64;
  std::vector<std::byte> outputs(bytes, std::byte{0x5A});
  std::vector<std::byte> inputs(bytes);
  std::vector<std::byte> frame(bytes);
  std::vector<double> samples;
  for (int i = 0; i < count; ++i) {
    const double begin = now_ns();
    for (int k = 0; k < kBatch; ++k) {
      std::memcpy(frame.data(), outputs.data(), bytes);
      keep(*frame.data());
      std::memcpy(inputs.data(), frame.data(), bytes);
      keep(*inputs.data());
    }
    samples.push_back((now_ns() - begin - reading_cost_ns()) / kBatch);
  }
  return {"copy_process_image_out_and_in", summarize(std::move(samples))};
}

void add(Report& report, const char* pace, std::size_t axes, const Figures& figures, const Baseline& floor) {
  const auto name = fmt::format("{}_{}_axes", pace, axes);
  constexpr double kNsPerUs = 1000.0;
  const auto aim = axes == kWholeAimAxes ? std::optional(kWholeAimUs) : std::nullopt;
  const Baseline floor_us{floor.name, divided(floor.figures, kNsPerUs)};
  report.add({name, "whole_cycle", "us", divided(figures.whole_ns, kNsPerUs), aim, floor_us});
  report.add({name, "master_part", "ns", figures.master_ns, std::nullopt, floor});
  report.add({name, "master_part_per_axis", "ns", divided(figures.master_ns, static_cast<double>(axes)), kMasterAimNs,
              std::nullopt});
}

void measure_all(const Options& options) {
  Report report("cycle");
  const int cycles = options.count(kCycles);
  for (const std::size_t axes : {1U, 8U, 32U, 100U}) {
    claim_cpu(last_cpu());
    rt::VirtualClock virtual_time;
    const auto figures = measure<BackToBackRunner>(virtual_time, axes, cycles);
    const auto floor = copy_process_image(figures.image_bytes, cycles / 10);
    add(report, "back_to_back", axes, figures, floor);
    const auto name = fmt::format("paced_{}_axes", axes);
    const double period_ns = std::chrono::duration<double, std::nano>(LineRig::kPeriod).count();
    if (const auto note = beyond_real_time(name, figures.whole_ns.p50 / period_ns)) {
      report.note(*note);
      continue;
    }
    // The cycle uses the last processor. Bringing up a hundred simulated drives needs half of another one: on a shared
    // processor it may never complete, because the firmware of the drives must run meanwhile.
    claim_cpu(std::max(0, last_cpu() - 1));
    rt::MonotonicClock real_time;
    const auto paced = undisturbed(name, [&] { return measure<PacedRunner>(real_time, axes, cycles); });
    add(report, "paced", axes, paced, floor);
  }
  report.note(
      fmt::format("back_to_back: cycles without a pause on virtual time; paced: one every 125 us in a real-time\n"
                  "thread that sleeps in between. Half of the cycles are measured as a whole, half for the\n"
                  "master's part. A reading of the clock takes {:.1f} ns; the measurement's own are taken out,\n"
                  "the cycle's own (paced only) are not.",
                  reading_cost_ns()));
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "What does a whole cycle cost for 1, 8, 32 and 100 axes, and what the master's part alone?",
             measure_all);
}
