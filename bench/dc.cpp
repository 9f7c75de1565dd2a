// How well are the clocks of a line together? Seeded scenarios on virtual time, judged by the true times of the
// simulated clocks: what the registers say of themselves is not asked.
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/line.hpp"
#include "driveline/wire/frame.hpp"
#include "support/environment.hpp"
#include "support/report.hpp"

namespace {

using namespace driveline;
using namespace driveline::bench;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// From here on the loops have settled; what is measured is the steady state.
constexpr nanoseconds kSettle = 3s;
constexpr nanoseconds kMeasured = 10s;
constexpr double kPeakAimNs = 40.0;
constexpr double kRmsAimNs = 15.0;
constexpr double kLockAimMs = 1000.0;
constexpr double kPhaseAimNs = 1000.0;

/// Wake-up latency of a thread under SCHED_FIFO on a busy virtual machine, as an assumption in the range of what
/// program `wake` shows: upper ends in ns and how many of 10,000 wake-ups are below.
struct LatencyStep {
  double up_to_ns;
  int of_10000;
};
constexpr LatencyStep kWakeLatency[] = {{100, 4200},    {1'000, 5600},  {4'000, 7900},  {8'000, 9000},
                                        {20'000, 9890}, {50'000, 9990}, {90'000, 10000}};

/// What a line is made of.
struct Scenario {
  std::string name;
  std::size_t slaves = 2;
  nanoseconds period = 125us;
  std::function<slaves::Wiring(std::size_t)> wiring = [](std::size_t n) { return slaves::Wiring::line(n, 25ns); };
  double ppm = 100.0;  ///< of the oscillators, either way
  double temperature_ppm_per_s = 0.0;
  nanoseconds jitter = 0ns;  ///< of receive times
  bool wake_jitter = false;
  double loss = 0.0;  ///< share of the frames
  bool aims = false;  ///< those for 64 slaves hold
};

/// A device without a life of its own.
class ClockOnly final : public slaves::Device {
 public:
  ClockOnly() {
    profile_.sii_image.resize(128);
    profile_.sii_image[14] = static_cast<std::byte>(
        esi::sii_checksum(std::span(std::as_const(profile_.sii_image)).first<esi::SiiConfigArea::kSize>()));
  }
  const slaves::DeviceProfile& profile() const noexcept override { return profile_; }
  std::size_t process_data_size(std::size_t) const noexcept override { return 0; }
  wire::AlStatusCode transition(wire::AlState, wire::AlState) noexcept override { return wire::AlStatusCode::kNoError; }
  void fall_back(wire::AlState, wire::AlState, wire::AlStatusCode) noexcept override {}
  void write_outputs(std::size_t, std::span<const std::byte>) noexcept override {}
  void read_inputs(std::size_t, std::span<std::byte>) noexcept override {}
  void mailbox_request(std::span<const std::byte>) override {}
  std::size_t mailbox_reply(std::span<std::byte>) override { return 0; }
  void advance(nanoseconds) noexcept override {}
  nanoseconds process_data_period() const noexcept override { return 1ms; }

 private:
  slaves::DeviceProfile profile_;
};

/// Wakes late as the histogram says.
class LateClock final : public rt::Clock {
 public:
  LateClock(rt::VirtualClock& inner, bool late) : inner_(inner), late_(late) {}
  [[nodiscard]] nanoseconds now() const noexcept override { return inner_.now(); }
  void sleep_until(nanoseconds deadline) noexcept override {
    wanted_ = deadline;
    inner_.sleep_until(deadline + latency());
  }
  /// When the last sleep was to end: the grid instant of the cycle.
  [[nodiscard]] nanoseconds wanted() const { return wanted_; }
  void spin() noexcept override { inner_.spin(); }

 private:
  nanoseconds latency() {
    if (!late_) return 0ns;
    const int rank = std::uniform_int_distribution<int>(0, 9999)(random_);
    double from = 0.0;
    for (const auto& step : kWakeLatency) {
      if (rank < step.of_10000)
        return nanoseconds{std::llround(std::uniform_real_distribution<double>(from, step.up_to_ns)(random_))};
      from = step.up_to_ns;
    }
    return 0ns;
  }

  rt::VirtualClock& inner_;
  bool late_;
  nanoseconds wanted_{};
  std::mt19937 random_{11};
};

/// Loses frames once told to, and notes when the cyclic ones are sent. Takes what comes out at the far end of a ring
/// too.
class BenchPort final : public port::Port {
 public:
  BenchPort(slaves::Line& line, double loss) : line_(line), loss_(loss) {}
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    if (std::bernoulli_distribution(loss_)(random_)) {
      ++lost;
      return port::SendStatus::kSent;
    }
    const auto status = line_.send(frame);
    if (static_cast<wire::Command>(frame[wire::kDatagramsOffset]) == wire::Command::kBrd)
      cyclic_sent = line_.last_send_time();
    return status;
  }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    auto frame = line_.receive();
    return frame ? frame : line_.secondary().receive();
  }
  bool wait_readable(nanoseconds deadline) noexcept override {
    for (auto time = line_.last_send_time(); time < deadline; time += 1us) {
      if (line_.wait_readable(time) || line_.secondary().wait_readable(time)) return true;
    }
    return line_.wait_readable(deadline);
  }
  [[nodiscard]] nanoseconds last_send_time() const noexcept override { return line_.last_send_time(); }

  nanoseconds cyclic_sent{};
  std::size_t lost = 0;

 private:
  slaves::Line& line_;
  double loss_;
  std::mt19937 random_{13};
};

class Run {
 public:
  explicit Run(const Scenario& scenario)
      : scenario_(scenario),
        wiring_(scenario.wiring(scenario.slaves)),
        line_(clock_, make_slaves(scenario), {}, wiring_),
        port_(line_, scenario.loss),
        late_(clock_, scenario.wake_jitter),
        master_(port_, late_, settings()) {}

  /// Time from the first cycle to OP, lock of cycle and clocks included.
  nanoseconds start() {
    check(master_.scan());
    ecat_master::dc::ClockPlan plan;
    plan.period = scenario_.period;
    plan.frame_lead = plan.period / 2;
    plan.slaves.resize(scenario_.slaves, {{ecat_master::dc::kActivateSync0, plan.period, {}, {}, {}}, 0ns});
    master_.use_clocks(std::move(plan));
    check(master_.configure({}));
    ecat_master::CyclicCore::Settings settings;
    settings.period = scenario_.period;
    settings.receive_window = scenario_.period * 3 / 4;
    const auto begin = clock_.now();
    const auto started = master_.start_cycle(nullptr, {}, settings, [this](ecat_master::CyclicCore& core) {
      return std::make_unique<ecat_master::InlineRunner>(core, late_);
    });
    if (!started) throw std::runtime_error(started.error());
    check(master_.go_operational());
    find_ways();
    return clock_.now() - begin;
  }

  /// Opens the ring between the two middle slaves.
  void break_ring() {
    if (!line_.break_cable({scenario_.slaves / 2 - 1, 1})) throw std::runtime_error("no cable to break");
  }

  void pass(nanoseconds duration) {
    const auto end = clock_.now() + duration;
    while (clock_.now() < end) master_.pass(nanoseconds{1});
  }

  /// Runs for `duration` and measures: every slave's SYNC0 against that of the reference clock, and the frames.
  void measure(nanoseconds duration, std::size_t slaves) {
    const auto end = clock_.now() + duration;
    const auto& reference = clock_of(0);
    for (int cycle = 0; clock_.now() < end; ++cycle) {
      master_.pass(nanoseconds{1});
      const auto& clocks = *master_.clocks();
      const auto arrival = system_time(reference, port_.cyclic_sent + way_to_reference_);
      const auto wanted = clocks.start - static_cast<std::uint64_t>(clocks.frame_lead.count());
      const auto error = ecat_master::dc::difference(arrival, wanted);
      phase_.push_back(magnitude(error));
      grid_phase_.push_back(magnitude(error - (port_.cyclic_sent - late_.wanted())));
      if (cycle % 16 == 0) measure_sync0(slaves);
    }
  }

  [[nodiscard]] const std::vector<double>& sync0() const { return sync0_; }
  [[nodiscard]] const std::vector<double>& phase() const { return phase_; }
  /// The same had the frames been sent when they should.
  [[nodiscard]] const std::vector<double>& grid_phase() const { return grid_phase_; }
  [[nodiscard]] const BenchPort& port() const { return port_; }

 private:
  static ecat_master::Master::Settings settings() {
    ecat_master::Master::Settings settings;
    settings.clock_timeout = 20s;
    return settings;
  }
  static std::vector<std::unique_ptr<slaves::Slave>> make_slaves(const Scenario& scenario) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> ppm(-scenario.ppm, scenario.ppm);
    std::uniform_int_distribution<std::int64_t> start(0, std::int64_t{1} << 60);
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (std::size_t i = 0; i < scenario.slaves; ++i) {
      slaves::SlaveOptions options;
      options.clock.start = nanoseconds{start(random)};
      options.clock.drift_ppm = ppm(random);
      options.clock.receive_jitter = scenario.jitter;
      options.clock.temperature_ppm_per_s = scenario.temperature_ppm_per_s;
      options.clock.temperature_span_ppm = scenario.temperature_ppm_per_s > 0.0 ? 20.0 : 0.0;
      options.clock.seed = i + 1;
      made.push_back(std::make_unique<slaves::Slave>(std::make_unique<ClockOnly>(), options));
    }
    return made;
  }
  static void check(const ecat_master::Result<void>& done) {
    if (!done) throw std::runtime_error(ecat_master::describe(done.error()));
  }

  [[nodiscard]] slaves::DistributedClock& clock_of(std::size_t position) {
    return line_.slave(numbers_[position]).esc().clock();
  }
  static std::uint64_t system_time(const slaves::DistributedClock& clock, nanoseconds time) {
    return static_cast<std::uint64_t>(clock.system_time(time).count());
  }

  [[nodiscard]] double magnitude(nanoseconds error) const {
    return std::abs(static_cast<double>(ecat_master::dc::wrap_to_cycle(error, scenario_.period).count()));
  }

  /// Slaves by position, and the true way to the reference clock.
  void find_ways() {
    std::vector<slaves::SlavePorts> ports(scenario_.slaves);
    for (std::size_t i = 0; i < ports.size(); ++i) {
      for (unsigned p = 0; p < slaves::kPortCount; ++p) {
        ports[i].closed[p] = wiring_.at({i, p}).kind == slaves::Wiring::End::Kind::kNothing;
      }
    }
    slaves::FramePath path;
    path.trace(wiring_, ports, slaves::MasterPort::kPrimary);
    for (const auto& step : path.steps()) numbers_.push_back(step.slave);
    way_to_reference_ = path.steps().front().time;
  }

  /// The true distance of the last SYNC0 of every slave from that of the reference.
  void measure_sync0(std::size_t slaves) {
    const auto reference = last_pulse(0);
    for (std::size_t i = 1; i < slaves; ++i) {
      const auto distance = ecat_master::dc::wrap_to_cycle(last_pulse(i) - reference, scenario_.period);
      sync0_.push_back(std::abs(static_cast<double>(distance.count())));
    }
  }
  [[nodiscard]] nanoseconds last_pulse(std::size_t position) {
    const auto& pulse = clock_of(position).last_sync0();
    if (!pulse) throw std::runtime_error(fmt::format("slave {} has made no SYNC0", position));
    return *pulse;
  }

  Scenario scenario_;
  rt::VirtualClock clock_{1s};
  slaves::Wiring wiring_;
  slaves::Line line_;
  BenchPort port_;
  LateClock late_;
  ecat_master::Master master_;
  std::vector<std::size_t> numbers_;
  nanoseconds way_to_reference_{};
  std::vector<double> sync0_;
  std::vector<double> phase_;
  std::vector<double> grid_phase_;
};

Summary one(double value) {
  return {1, value, value, value, value};
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

void add_rows(Report& report, const Scenario& scenario, const std::string& name, const Run& run) {
  const auto differences = summarize(run.sync0());
  const auto aim = [&scenario](double value) { return scenario.aims ? std::optional(value) : std::nullopt; };
  report.add({name, "sync0_difference", "ns", differences, std::nullopt, std::nullopt});
  report.add({name, "sync0_peak", "ns", one(differences.max), aim(kPeakAimNs), std::nullopt});
  report.add({name, "sync0_rms", "ns", one(rms(run.sync0())), aim(kRmsAimNs), std::nullopt});
  report.add({name, "grid_phase_error", "ns", summarize(run.grid_phase()), kPhaseAimNs, std::nullopt});
  if (scenario.wake_jitter)
    report.add({name, "frame_phase_error", "ns", summarize(run.phase()), std::nullopt, std::nullopt});
}

/// A tree: every third slave carries a branch of two.
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
    // A frame needs a microsecond for each slave there and back: not to be had in 125 us.
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
  return list;
}

void measure(const Options& options) {
  Report report("dc");
  const auto measured = options.quick ? kMeasured / 10 : kMeasured;
  for (const auto& scenario : scenarios()) {
    fmt::print(stderr, "{} ...\n", scenario.name);
    Run run(scenario);
    const auto lock = run.start();
    report.add(
        {scenario.name, "time_to_lock", "ms", one(static_cast<double>(lock.count()) / 1e6), kLockAimMs, std::nullopt});
    run.pass(kSettle);
    run.measure(measured, scenario.slaves);
    add_rows(report, scenario, scenario.name, run);
    if (!scenario.name.starts_with("ring")) continue;
    // Of the broken ring the part in front of the break is measured: no drift datagram reaches the other from this
    // side.
    Run broken(scenario);
    static_cast<void>(broken.start());
    broken.pass(kSettle);
    broken.break_ring();
    broken.measure(measured, scenario.slaves / 2);
    add_rows(report, scenario, scenario.name + "_broken", broken);
  }
  report.note("true times of the simulated clocks, 10 ns resolution; n of sync0_difference: slaves times pulses");
  report.print(options);
}

}  // namespace

int main(int argc, char** argv) {
  return driveline::bench::run(argc, argv, "How well are the clocks of a line together?", measure);
}
