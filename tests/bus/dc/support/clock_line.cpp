#include "clock_line.hpp"

#include <algorithm>
#include <random>
#include <stdexcept>

#include "driveline/slaves/line/frame_path.hpp"
#include "test_device.hpp"

namespace driveline::bus_test {

using ecat_master::describe;

std::vector<ClockSpec> random_clocks(std::size_t count, double ppm, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> speed(-ppm, ppm);
  std::uniform_int_distribution<std::int64_t> start(0, std::int64_t{1} << 60);
  std::vector<ClockSpec> specs(count);
  for (auto& spec : specs) {
    spec.ppm = speed(random);
    spec.start = nanoseconds{start(random)};
  }
  return specs;
}

ClockLine::ClockLine(const std::vector<ClockSpec>& specs, std::optional<slaves::Wiring> wiring,
                     const slaves::LineOptions& options, nanoseconds now)
    : clock(now),
      specs_(specs),
      options_(options),
      wiring_(wiring ? *wiring : slaves::Wiring::line(specs.size(), options.cable_delay)) {
  std::vector<std::unique_ptr<slaves::Slave>> made;
  for (const auto& spec : specs) {
    auto device = std::make_unique<slaves::test::TestDevice>();
    device->own_profile.sync_managers.clear();
    device->own_profile.distributed_clock = spec.clock;
    device->own_profile.distributed_clock_64bit = spec.wide;
    slaves::SlaveOptions slave_options;
    slave_options.clock.start = spec.start;
    slave_options.clock.drift_ppm = spec.ppm;
    slave_options.clock.resolution = spec.resolution;
    slave_options.clock.receive_jitter = spec.jitter;
    slave_options.clock.temperature_ppm_per_s = spec.temperature_ppm_per_s;
    slave_options.clock.temperature_span_ppm = spec.temperature_ppm_per_s > 0.0 ? 20.0 : 0.0;
    slave_options.clock.seed = made.size() + 1;
    made.push_back(std::make_unique<slaves::Slave>(std::move(device), slave_options));
  }
  line_ = std::make_unique<slaves::SimulatedLine>(clock, std::move(made), options, wiring_);
}

void ClockLine::open(port::Port* port) {
  master_ = std::make_unique<ecat_master::Master>(port != nullptr ? *port : *line_, clock);
  if (auto done = master_->scan(); !done) throw std::runtime_error(describe(done.error()));
  if (auto done = master_->enter_pre_op(); !done) throw std::runtime_error(describe(done.error()));
  refs_.clear();
  numbers_.assign(size(), size());
  for (const auto& found : master_->slaves()) {
    refs_.push_back(found.info.ref);
    for (std::size_t number = 0; number < size(); ++number) {
      if (line_->slave(number).esc().memory().get(wire::reg::kStationAddress) == found.info.ref.station)
        numbers_[found.info.ref.position] = number;
    }
  }
  passing_.assign(size(), nanoseconds{0});
  retrace();
  planned_ = passing_;
}

void ClockLine::retrace() {
  // Trace the path of a frame with the same code that carries the frames.
  std::vector<slaves::SlavePorts> ports(size());
  for (std::size_t i = 0; i < size(); ++i) {
    ports[i].delays = options_.delays;
    for (unsigned p = 0; p < slaves::kPortCount; ++p) {
      const auto& end = wiring_.at({i, p});
      const bool dead = end.kind == slaves::Wiring::End::Kind::kSlave && !line_->slave(end.slave.slave).powered();
      ports[i].closed[p] = end.kind == slaves::Wiring::End::Kind::kNothing || dead;
    }
  }
  slaves::FramePath path;
  path.trace(wiring_, ports, slaves::MasterPort::kPrimary);
  for (const auto& step : path.steps()) {
    const auto position = std::find(numbers_.begin(), numbers_.end(), step.slave) - numbers_.begin();
    passing_[static_cast<std::size_t>(position)] = step.time;
  }
}

ecat_master::dc::ClockPlan ClockLine::plan(nanoseconds period) const {
  ecat_master::dc::ClockPlan plan;
  plan.period = period;
  plan.frame_lead = period / 2;
  plan.slaves.resize(size());
  for (std::size_t i = 0; i < size(); ++i) {
    if (!spec(i).clock) continue;
    plan.slaves[i].signals.assign_activate = ecat_master::dc::kActivateSync0;
    plan.slaves[i].signals.sync0_cycle = period;
  }
  return plan;
}

ecat_master::Result<ecat_master::dc::LineClocks> ClockLine::bring_up(const ecat_master::dc::ClockPlan& plan) {
  return ecat_master::dc::bring_up_clocks(master_->bus(), refs_, master_->topology(), plan);
}

double ClockLine::true_delay(std::size_t from, std::size_t to) const {
  return static_cast<double>((passing_[to] - passing_[from]).count()) * (1.0 + spec(from).ppm * 1e-6);
}

std::uint64_t ClockLine::system_time(std::size_t position) {
  return static_cast<std::uint64_t>(slave(position).esc().clock().system_time(clock.now()).count());
}

nanoseconds ClockLine::ahead(std::size_t position, std::size_t reference) {
  return nanoseconds{static_cast<std::int32_t>(static_cast<std::uint32_t>(system_time(position)) -
                                               static_cast<std::uint32_t>(system_time(reference)))};
}

}  // namespace driveline::bus_test
