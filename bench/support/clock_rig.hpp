#pragma once

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/port/redundant_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/wire/frame.hpp"
#include "support/latency_histogram.hpp"

/// Seeded lines of clocks on virtual time whose true times are known.
namespace driveline::bench {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// A line and its disturbances.
struct Scenario {
  std::string name;
  std::size_t slaves = 2;
  nanoseconds period = 125us;
  std::function<slaves::Wiring(std::size_t)> wiring = [](std::size_t n) { return slaves::Wiring::line(n, 25ns); };
  double ppm = 100.0;  ///< range of the oscillators' deviations, plus and minus
  double temperature_ppm_per_s = 0.0;
  nanoseconds jitter = 0ns;  ///< jitter of receive times
  bool wake_jitter = false;
  double loss = 0.0;                       ///< share of lost frames
  bool aims = false;                       ///< the aims for 64 slaves apply
  bool ring = false;                       ///< the master is at both ends
  bool led = true;                         ///< the master leads both parts of an open ring
  std::optional<std::uint16_t> reference;  ///< position of the reference clock; none: the first slave
};

/// A device without an application.
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

/// A clock that wakes up late, distributed like a measured histogram.
class LateClock final : public rt::Clock {
 public:
  /// `histogram`: null: always on time.
  LateClock(rt::VirtualClock& inner, const LatencyHistogram* histogram) : inner_(inner), histogram_(histogram) {}
  [[nodiscard]] nanoseconds now() const noexcept override { return inner_.now(); }
  void sleep_until(nanoseconds deadline) noexcept override {
    wanted_ = deadline;
    inner_.sleep_until(deadline + (histogram_ == nullptr ? nanoseconds{0} : histogram_->draw(random_)));
  }
  /// The end of the last sleep as requested: the grid instant of the cycle.
  [[nodiscard]] nanoseconds wanted() const { return wanted_; }
  void spin() noexcept override { inner_.spin(); }

 private:
  rt::VirtualClock& inner_;
  const LatencyHistogram* histogram_;
  nanoseconds wanted_{};
  std::mt19937 random_{11};
};

/// Loses frames, and records when the cyclic ones are sent.
class BenchPort final : public port::Port {
 public:
  BenchPort(slaves::SimulatedLine& line, double loss) : line_(line), loss_(loss) {}
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
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override { return line_.receive(); }
  bool wait_readable(nanoseconds deadline) noexcept override { return line_.wait_readable(deadline); }
  [[nodiscard]] nanoseconds last_send_time() const noexcept override { return line_.last_send_time(); }

  nanoseconds cyclic_sent{};
  std::size_t lost = 0;

 private:
  slaves::SimulatedLine& line_;
  double loss_;
  std::mt19937 random_{13};
};

/// A line of clocks with a cycling master, and its true times.
class ClockRig {
 public:
  explicit ClockRig(const Scenario& scenario)
      : scenario_(scenario),
        wiring_(scenario.wiring(scenario.slaves)),
        line_(clock_, make_slaves(scenario), {}, wiring_),
        port_(line_, scenario.loss),
        ring_(port_, line_.secondary(), clock_),
        late_(clock_, scenario.wake_jitter ? &wake_latency() : nullptr),
        master_(scenario.ring ? static_cast<port::Port&>(ring_) : port_, late_, settings()) {
    if (scenario.ring && scenario.led) master_.use_ring(ring_);
  }

  /// Time from the first cycle to OP, including the lock of cycle and clocks.
  nanoseconds start() {
    check(master_.scan());
    ecat_master::dc::ClockPlan plan;
    plan.period = scenario_.period;
    plan.frame_lead = plan.period / 2;
    plan.reference = scenario_.reference;
    for (std::size_t i = 0; i < scenario_.slaves; ++i) {
      // Slaves before the reference clock cannot follow it.
      if (i < scenario_.reference.value_or(0)) {
        plan.slaves.emplace_back();
      } else {
        plan.slaves.push_back({{ecat_master::dc::kActivateSync0, plan.period, {}, {}, {}}});
      }
    }
    master_.use_clocks(std::move(plan));
    check(master_.configure({}));
    ecat_master::CyclicCore::Settings settings;
    settings.period = scenario_.period;
    settings.receive_window = scenario_.period * 3 / 4;
    const auto begin = clock_.now();
    const auto started = master_.start_cycle(nullptr, {}, settings, [this](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, late_);
    });
    if (!started) throw std::runtime_error(started.error().message());
    check(master_.go_operational());
    find_ways();
    return clock_.now() - begin;
  }

  [[nodiscard]] nanoseconds now() const { return clock_.now(); }
  [[nodiscard]] ecat_master::Master& master() { return master_; }
  [[nodiscard]] slaves::SimulatedLine& line() { return line_; }
  /// True distance of a slave's last SYNC0 from that of slave `reference`, in ns.
  [[nodiscard]] double sync0_ahead(std::size_t slave, std::size_t reference = 0) {
    return static_cast<double>(off_beat(last_pulse(slave) - last_pulse(reference)).count());
  }
  /// Lateness of the last cyclic frame by the reference clock, in ns.
  [[nodiscard]] double arrival_error() {
    const auto& clocks = *master_.clocks();
    const auto arrival = system_time(clock_of(0), port_.cyclic_sent + way_to_reference_);
    const auto wanted = clocks.start - static_cast<std::uint64_t>(clocks.frame_lead.count());
    return static_cast<double>(off_beat(nanoseconds{static_cast<std::int64_t>(arrival - wanted)}).count());
  }

  /// Opens the ring between the two middle slaves.
  void break_ring() {
    if (!line_.break_cable({scenario_.slaves / 2 - 1, 1})) throw std::runtime_error("no cable to break");
  }

  /// Runs a cycle, and polls the clock supervision every five milliseconds, as `run` does.
  void cycle() {
    master_.pass(nanoseconds{1});
    if (clock_.now() < next_look_) return;
    next_look_ = clock_.now() + 5ms;
    check(master_.clock_watch()->poll());
  }
  void pass(nanoseconds duration) {
    const auto end = clock_.now() + duration;
    while (clock_.now() < end) cycle();
  }

  /// Runs for `duration` and measures every slave's SYNC0 against that of the reference clock, and the frames.
  void measure(nanoseconds duration, std::size_t slaves) {
    const auto end = clock_.now() + duration;
    for (int number = 0; clock_.now() < end; ++number) {
      cycle();
      const auto error = nanoseconds{std::llround(arrival_error())};
      phase_.push_back(magnitude(error));
      grid_phase_.push_back(magnitude(error - (port_.cyclic_sent - late_.wanted())));
      if (number % 16 == 0) measure_sync0(slaves);
    }
  }

  [[nodiscard]] const std::vector<double>& sync0() const { return sync0_; }
  [[nodiscard]] const std::vector<double>& phase() const { return phase_; }
  /// The same without the deviation of the sending from the grid.
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

  /// Distance from the nearest multiple of the period. The bench judges the master, so it must not use the master's own
  /// arithmetic; 64 bits of mantissa represent every number of nanoseconds.
  [[nodiscard]] nanoseconds off_beat(nanoseconds distance) const {
    const auto rest =
        std::remainder(static_cast<long double>(distance.count()), static_cast<long double>(scenario_.period.count()));
    return nanoseconds{static_cast<std::int64_t>(rest)};
  }

  [[nodiscard]] double magnitude(nanoseconds error) const {
    return std::abs(static_cast<double>(off_beat(error).count()));
  }

  /// Finds the slaves by position, and the true delay to the reference clock.
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

  /// Records the true distances of the last SYNC0 of all slaves from that of the reference.
  void measure_sync0(std::size_t slaves) {
    const auto reference = last_pulse(0);
    for (std::size_t i = 1; i < slaves; ++i) {
      const auto distance = off_beat(last_pulse(i) - reference);
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
  slaves::SimulatedLine line_;
  BenchPort port_;
  port::RedundantPort ring_;
  LateClock late_;
  ecat_master::Master master_;
  nanoseconds next_look_{};
  std::vector<std::size_t> numbers_;
  nanoseconds way_to_reference_{};
  std::vector<double> sync0_;
  std::vector<double> phase_;
  std::vector<double> grid_phase_;
};

}  // namespace driveline::bench
