#include "clock_run.hpp"

#include <cmath>

#include "driveline/motion/cycle/cycle_runner.hpp"
#include "true_time.hpp"

namespace driveline::bus_test {

using ecat_master::describe;

namespace {

/// The SYNC0 pulses around the present, in true time: the last one and the next one.
struct Pulses {
  nanoseconds last;
  nanoseconds next;
};

Pulses pulses_of(slaves::Slave& slave) {
  const auto& clock = slave.esc().clock();
  if (!clock.last_sync0() || clock.sync_due() == slaves::DistributedClock::kNever)
    throw std::runtime_error("a slave makes no SYNC0");
  return {*clock.last_sync0(), clock.sync_due()};
}

nanoseconds nearer(nanoseconds a, nanoseconds b) {
  return std::chrono::abs(a) < std::chrono::abs(b) ? a : b;
}

}  // namespace

class ClockRun::Runner final : public motion::CycleRunner {
 public:
  Runner(ecat_master::CyclicCore& core, rt::Clock& clock, nanoseconds early, nanoseconds& grid)
      : core_(core), clock_(clock), timer_(clock, core.settings().period, nanoseconds{0}, early), grid_(grid) {}
  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override {
    timer_.start(core_.first_grid(clock_.now() + 4 * timer_.period()));
    return {};
  }
  void pass(nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      const auto cycle = timer_.wait_next();
      grid_ = cycle.grid;
      core_.cycle(cycle);
      timer_.shift_phase(core_.grid_shift());
    } while (clock_.now() < end);
  }
  void stop() override {}

 private:
  ecat_master::CyclicCore& core_;
  rt::Clock& clock_;
  rt::CycleTimer timer_;
  nanoseconds& grid_;
};

port::SendStatus ClockRun::Probe::send(std::span<const std::byte> frame) noexcept {
  ++frames;
  const auto first = first_datagram(frame);
  const auto status = inner_.send(frame);
  if (first.command == wire::Command::kBrd && first.ado == wire::reg::kAlStatus.address)
    cyclic_sent = inner_.last_send_time();
  return status;
}

ClockRun::ClockRun(ClockLine& line, const Options& options)
    : line_(line),
      probe_(options.port != nullptr ? *options.port : line.line()),
      clock_(
          line.clock, options.latency ? options.latency : [] { return nanoseconds{0}; }),
      process_data_(options.process_data),
      early_(options.early) {
  line_.open(&probe_);
  ecat_master::Master::Settings settings;
  settings.clock_timeout = options.clock_timeout;
  master_ = std::make_unique<ecat_master::Master>(probe_, clock_, settings);
  if (options.ring != nullptr) master_->use_ring(*options.ring);
}

std::string ClockRun::start(const ecat_master::dc::ClockPlan& plan) {
  if (auto done = master_->scan(); !done) return describe(done.error());
  if (!process_data_) {
    if (auto done = master_->enter_pre_op(); !done) return describe(done.error());
  }
  master_->use_clocks(plan);
  const auto prepared = process_data_ ? master_->configure({}) : master_->synchronise_clocks();
  if (!prepared) return describe(prepared.error());
  ecat_master::CyclicCore::Settings settings;
  settings.period = plan.period;
  settings.receive_window = plan.period * 3 / 4;
  const auto started = master_->start_cycle(nullptr, {}, settings, [this](ecat_master::CyclicCore& core) {
    return std::make_unique<Runner>(core, clock_, early_, grid_);
  });
  if (!started) return started.error().message();
  if (!process_data_) return {};
  if (auto done = master_->go_operational(); !done) return describe(done.error());
  return {};
}

void ClockRun::run(nanoseconds duration, const std::function<void()>& each) {
  constexpr auto kPoll = milliseconds{5};
  const auto end = line_.clock.now() + duration;
  auto next_poll = line_.clock.now();
  while (line_.clock.now() < end) {
    cycle();
    if (each) each();
    if (line_.clock.now() < next_poll) continue;
    next_poll += kPoll;
    if (auto done = watch().poll(); !done) throw std::runtime_error(describe(done.error()));
  }
}

nanoseconds ClockRun::arrival_error() {
  const auto& clocks = this->clocks();
  const auto start = *master_->clocks();
  // Frames pass another reference clock later, by its delay from the first one.
  const auto reference = clocks.reference;
  const auto arrival = probe_.cyclic_sent + line_.passing(reference);
  const auto way = line_.planned_passing(reference) - line_.planned_passing(start.reference);
  const auto pulses = pulses_of(line_.slave(reference));
  const auto own_time = [this, reference](nanoseconds distance) {
    return nanoseconds{std::llround(static_cast<double>(distance.count()) * (1.0 + line_.spec(reference).ppm * 1e-6))};
  };
  // The frame was due `frame_lead` before a pulse: one of those around the present, the previous or the following one.
  const auto period = pulses.next - pulses.last;
  auto error = nanoseconds::max();
  for (const auto pulse : {pulses.last - period, pulses.last, pulses.next, pulses.next + period})
    error = nearer(own_time(arrival - way - pulse) + start.frame_lead, error);
  return error;
}

nanoseconds ClockRun::grid_error() {
  return off_beat(arrival_error() - (probe_.cyclic_sent - grid_), master_->clocks()->period);
}

nanoseconds ClockRun::worst_sync0() {
  nanoseconds worst{0};
  const auto& clocks = this->clocks();
  const auto reference = pulses_of(line_.slave(clocks.reference));
  for (std::size_t i = 0; i < line_.size(); ++i) {
    if (!clocks.slaves[i].follows || !line_.slave(i).powered()) continue;
    const auto own = pulses_of(line_.slave(i));
    // One of the two may already have made its pulse while the other has not.
    const auto apart = nearer(own.last - reference.last, nearer(own.last - reference.next, own.next - reference.last));
    worst = std::max(worst, std::chrono::abs(apart));
  }
  return worst;
}

std::vector<std::string> ClockRun::events() {
  std::vector<std::string> sentences;
  for (const auto& event : watch().take_events()) sentences.push_back(ecat_master::dc::describe(event));
  return sentences;
}

}  // namespace driveline::bus_test
