#include "support/clock_figures.hpp"

#include <algorithm>
#include <fstream>
#include <limits>

#include "driveline/ecat_master/dc/phase_controller.hpp"
#include "support/clock_rig.hpp"

namespace driveline::bench {
namespace {

/// A CSV file with a curve.
class Curve {
 public:
  Curve(const std::string& folder, const std::string& name, const std::string& header) : out_(folder + "/" + name) {
    if (!out_) throw std::runtime_error(fmt::format("{}/{}: cannot be written", folder, name));
    out_ << header << '\n';
  }
  void row(double x, const std::vector<double>& values) {
    out_ << fmt::format("{:.6f}", x);
    for (const double value : values) out_ << fmt::format(",{:.1f}", value);
    out_ << '\n';
  }

 private:
  std::ofstream out_;
};

/// The controller alone, starting with an error of 1 % of the period and a reference clock that is 50 ppm fast.
void write_lock_in(const std::string& folder) {
  for (const auto period : {125us, 250us, 1000us, 4000us, 10000us}) {
    Curve curve(folder, fmt::format("lock_in_{}.csv", period.count()), "ms,percent of the period,locked");
    ecat_master::dc::PhaseController::Settings settings;
    settings.period = period;
    ecat_master::dc::PhaseController controller(settings);
    const auto length = static_cast<double>(nanoseconds{period}.count());
    double error = length * 0.01;
    for (nanoseconds time{0}; time < 500ms; time += period) {
      curve.row(static_cast<double>(time.count()) * 1e-6,
                {100.0 * 100.0 * error / length, controller.locked() ? 1.0 : 0.0});
      error += length * 50e-6;
      error += static_cast<double>(controller.update(nanoseconds{std::llround(error)}).count());
    }
  }
}

double seconds_since(nanoseconds begin, nanoseconds now) {
  return static_cast<double>((now - begin).count()) * 1e-9;
}

/// The largest true distance of any SYNC0 from that of the reference, every few cycles, for one disturbance each.
void write_disturbances(const std::string& folder) {
  struct Case {
    std::string name;
    std::function<void(Scenario&)> disturb;
  };
  const std::vector<Case> cases{
      {"quiet", [](Scenario&) {}},
      {"receive_jitter", [](Scenario& s) { s.jitter = 20ns; }},
      {"temperature", [](Scenario& s) { s.temperature_ppm_per_s = 1.0; }},
      {"wake_jitter", [](Scenario& s) { s.wake_jitter = true; }},
      {"loss", [](Scenario& s) { s.loss = 0.01; }},
  };
  for (const auto& one : cases) {
    Scenario scenario;
    scenario.slaves = 16;
    one.disturb(scenario);
    ClockRig rig(scenario);
    static_cast<void>(rig.start());
    rig.pass(2s);
    Curve curve(folder, "disturbed_" + one.name + ".csv", "s,farthest SYNC0 ns,frame ns");
    const auto begin = rig.now();
    for (int cycle = 0; cycle < 8000; ++cycle) {
      rig.cycle();
      if (cycle % 8 != 0) continue;
      double farthest = 0.0;
      for (std::size_t i = 1; i < scenario.slaves; ++i) {
        const double ahead = rig.sync0_ahead(i);
        if (std::abs(ahead) > std::abs(farthest)) farthest = ahead;
      }
      curve.row(seconds_since(begin, rig.now()), {farthest, rig.arrival_error()});
    }
  }
}

/// Least and greatest value since the last row.
struct Span {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();

  void add(double value) noexcept {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
};

/// SYNC0 of `shown` relative to that of slave `reference`, around an event after 0.2 s: least and greatest of every 16
/// cycles, so that no extreme is lost.
void write_event(const std::string& folder, const std::string& name, ClockRig& rig, std::size_t reference,
                 const std::vector<std::size_t>& shown, nanoseconds duration, const std::function<void()>& event) {
  std::string header = "s";
  for (const auto slave : shown) header += fmt::format(",slave {0} least,slave {0} greatest", slave);
  Curve curve(folder, name, header);
  const auto begin = rig.now();
  bool happened = false;
  std::vector<Span> spans(shown.size());
  for (int cycle = 1; rig.now() - begin < duration; ++cycle) {
    if (!happened && rig.now() - begin >= 200ms) {
      event();
      happened = true;
    }
    rig.cycle();
    for (std::size_t i = 0; i < shown.size(); ++i) spans[i].add(rig.sync0_ahead(shown[i], reference));
    if (cycle % 16 != 0) continue;
    std::vector<double> row;
    for (const auto& span : spans) row.insert(row.end(), {span.least, span.greatest});
    curve.row(seconds_since(begin, rig.now()), row);
    std::fill(spans.begin(), spans.end(), Span{});
  }
}

/// The reference clock is alone on a branch and loses its supply.
void write_takeover(const std::string& folder) {
  Scenario scenario;
  scenario.slaves = 6;
  scenario.reference = 1;
  scenario.wiring = [](std::size_t count) {
    slaves::Wiring wiring(count);
    wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0}, 20ns);
    wiring.connect({0, 3}, {1, 0}, 500ns);
    wiring.connect({0, 1}, {2, 0}, 70ns);
    for (std::size_t i = 3; i < count; ++i) wiring.connect({i - 1, 1}, {i, 0}, 90ns);
    return wiring;
  };
  ClockRig rig(scenario);
  static_cast<void>(rig.start());
  rig.pass(2s);
  write_event(folder, "takeover.csv", rig, 2, {3, 4, 5}, 2s, [&rig] { rig.line().set_power(1, false); });
}

/// A ring of 16 slaves with drifting frequencies, opened before slave 8; with and without the lead of the second
/// interface.
void write_broken_ring(const std::string& folder) {
  for (const bool led : {true, false}) {
    Scenario scenario;
    scenario.slaves = 16;
    scenario.temperature_ppm_per_s = 1.0;
    scenario.wiring = [](std::size_t n) { return slaves::Wiring::ring(n, 25ns); };
    scenario.ring = true;
    scenario.led = led;
    ClockRig rig(scenario);
    static_cast<void>(rig.start());
    rig.pass(2s);
    write_event(folder, led ? "ring_led.csv" : "ring_free.csv", rig, 0, {1, 4, 7, 8, 11, 15}, 3s,
                [&rig] { rig.break_ring(); });
  }
}

}  // namespace

void write_clock_figures(const std::string& folder) {
  write_lock_in(folder);
  write_disturbances(folder);
  write_takeover(folder);
  write_broken_ring(folder);
}

}  // namespace driveline::bench
