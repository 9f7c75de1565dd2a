// How well are the clocks of a line synchronised? Seeded scenarios on virtual time, judged by the true times of the
// simulated clocks instead of their registers.
#include <fmt/format.h>
#include <cmath>
#include <string>
#include <vector>

#include "support/clock_figures.hpp"
#include "support/clock_rig.hpp"
#include "support/report.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;

/// The loops have settled after this time, so that the steady state is measured.
constexpr nanoseconds kSettle = 3s;
constexpr nanoseconds kMeasured = 10s;
constexpr double kPeakAimNs = 40.0;
constexpr double kRmsAimNs = 15.0;
constexpr double kLockAimMs = 1000.0;
constexpr double kPhaseAimNs = 1000.0;

Summary one(double value) {
  return {1, value, value, value, value};
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

void add_rows(Report& report, const Scenario& scenario, const std::string& name, const ClockRig& run) {
  const auto differences = summarize(run.sync0());
  const auto aim = [&scenario](double value) { return scenario.aims ? std::optional(value) : std::nullopt; };
  report.add({name, "sync0_difference", "ns", differences, std::nullopt, std::nullopt});
  report.add({name, "sync0_peak", "ns", one(differences.max), aim(kPeakAimNs), std::nullopt});
  report.add({name, "sync0_rms", "ns", one(rms(run.sync0())), aim(kRmsAimNs), std::nullopt});
  report.add({name, "grid_phase_error", "ns", summarize(run.grid_phase()), kPhaseAimNs, std::nullopt, kPhaseAimNs});
  if (scenario.wake_jitter)
    report.add({name, "frame_phase_error", "ns", summarize(run.phase()), std::nullopt, std::nullopt});
}

/// A tree: every third slave has a branch of two slaves.
slaves::Wiring branches(std::size_t count) {
  slaves::Wiring wiring(count);
  wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0}, 25ns);
  std::size_t trunk = 0;
  for (std::size_t i = 1; i < count; i += 3) {
    if (i + 1 < count) wiring.connect({trunk, 3}, {i + 1, 0}, 400ns);
    if (i + 2 < count) wiring.connect({i + 1, 1}, {i + 2, 0}, 80ns);
    wiring.connect({trunk, 1}, {i, 0}, 55ns);
    trunk = i;
  }
  return wiring;
}

std::vector<Scenario> scenarios() {
  std::vector<Scenario> list;
  for (const std::size_t count : {2U, 16U, 64U, 128U}) {
    Scenario plain;
    plain.name = fmt::format("line_{}", count);
    plain.slaves = count;
    plain.aims = count <= 64;
    // A frame needs about a microsecond per slave for both directions: too long for a period of 125 us.
    if (count > 64) plain.period = 250us;
    list.push_back(plain);
  }
  auto named = [&list](const std::string& name) -> Scenario& {
    Scenario scenario;
    scenario.name = name;
    scenario.slaves = 64;
    scenario.aims = true;
    return list.emplace_back(scenario);
  };
  named("line_64_temperature_1ppm_s").temperature_ppm_per_s = 1.0;
  named("line_64_receive_jitter_20ns").jitter = 20ns;
  named("line_64_wake_jitter").wake_jitter = true;
  named("line_64_loss_1pct").loss = 0.01;
  auto& all = named("line_64_everything");
  all.temperature_ppm_per_s = 1.0;
  all.jitter = 20ns;
  all.wake_jitter = true;
  all.loss = 0.01;
  named("branch_64").wiring = branches;
  auto& ring = named("ring_64");
  ring.wiring = [](std::size_t n) { return slaves::Wiring::ring(n, 25ns); };
  ring.ring = true;
  auto& wandering = list.emplace_back(ring);
  wandering.name = "ring_64_temperature_1ppm_s";
  wandering.temperature_ppm_per_s = 1.0;
  return list;
}

void measure(const Options& options) {
  if (!options.figures.empty()) return write_clock_figures(options.figures);
  Report report("dc");
  const auto measured = options.quick ? kMeasured / 10 : kMeasured;
  for (const auto& scenario : scenarios()) {
    fmt::print(stderr, "{} ...\n", scenario.name);
    ClockRig run(scenario);
    const auto lock = run.start();
    report.add(
        {scenario.name, "time_to_lock", "ms", one(static_cast<double>(lock.count()) / 1e6), kLockAimMs, std::nullopt});
    run.pass(kSettle);
    run.measure(measured, scenario.slaves);
    add_rows(report, scenario, scenario.name, run);
    if (!scenario.name.starts_with("ring")) continue;
    // Compare all 64 with the reference clock, including those behind the break, which get their time over the other
    // interface.
    ClockRig broken(scenario);
    static_cast<void>(broken.start());
    broken.pass(kSettle);
    broken.break_ring();
    broken.measure(measured, scenario.slaves);
    add_rows(report, scenario, scenario.name + "_broken", broken);
  }
  report.note("true times of the simulated clocks, 10 ns resolution; n of sync0_difference: slaves times pulses");
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return driveline::bench::run(argc, argv, "How well are the clocks of a line synchronized?", measure);
}
