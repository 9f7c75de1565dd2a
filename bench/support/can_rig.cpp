#include "support/can_rig.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "driveline/runtime/can/master_plan.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "support/retry.hpp"
#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

using std::chrono::nanoseconds;

runtime::LineConfig describe_can_axes(std::size_t axes, nanoseconds period) {
  auto config = describe_line(axes, period);
  config.can.emplace();
  for (std::size_t i = 0; i < axes; ++i) {
    config.slaves[i].can.node = static_cast<std::uint8_t>(i + 1);
    config.axes[i].mode = motion::cia402::Mode::kInterpolatedPosition;
    config.axes[i].period = period;
  }
  return config;
}

void require(const canopen::MasterResult<void>& done) {
  if (!done) throw std::runtime_error(canopen::describe(done.error().front(), "a node"));
}

}  // namespace

void TimedCanPort::reset(bool measure) noexcept {
  measure_ = measure;
  measured_ns_ = 0.0;
  calls_ = 0;
}

double TimedCanPort::inside_ns() const noexcept {
  return measured_ns_ - calls_ * reading_cost_ns();
}

double TimedCanPort::overhead_ns() const noexcept {
  return calls_ * reading_cost_ns();
}

template <typename Call>
auto TimedCanPort::timed(const Call& call) const noexcept {
  if (!measure_) return call();
  const double begin = now_ns();
  auto result = call();
  measured_ns_ += now_ns() - begin;
  ++calls_;
  return result;
}

canopen::SendStatus TimedCanPort::send(const canopen::Frame& frame) noexcept {
  return timed([&] { return inner_.send(frame); });
}

std::optional<canopen::ReceivedFrame> TimedCanPort::receive() noexcept {
  return timed([&] { return inner_.receive(); });
}

bool TimedCanPort::wait_readable(nanoseconds deadline) noexcept {
  return inner_.wait_readable(deadline);
}

canopen::PortStatistics TimedCanPort::statistics() const noexcept {
  return timed([&] { return inner_.statistics(); });
}

CanRig::CanRig(rt::VirtualClock& clock, std::size_t axes, nanoseconds period, nanoseconds path_duration)
    : path_duration_(path_duration),
      clock_(clock),
      config_(describe_can_axes(axes, period)),
      bus_(runtime::open_simulated_can_port(runtime::can_line_of(config_), {config_.can->bit_rate, false, false},
                                            clock)),
      port_(*bus_),
      rings_(axes),
      master_(port_, clock, runtime::make_master_plan(config_), {.listen = {}}) {}

void CanRig::bring_up(const canopen::CanMaster::MakeRunner& make_runner) {
  require(master_.boot());
  std::vector<motion::Axis> axes;
  for (const auto& axis : config_.axes) {
    axes.emplace_back(axis, master_.image().place(axis.slave), master_.image().configuration(axis.slave));
  }
  motion_ = std::make_unique<motion::Motion>(std::move(axes), sines(config_.axes, path_duration_),
                                             runtime::motion_settings(config_));
  const auto started = master_.start_cycle(motion_.get(), rings_.ends(), {}, make_runner);
  if (!started) throw std::runtime_error(started.error().message());
  require(master_.go_operational());
  motion_->request_start();
  const auto deadline = clock_.now() + std::chrono::seconds{5};
  while (motion_->phase() != motion::MotionPhase::kFollowing) {
    if (clock_.now() > deadline) throw std::runtime_error("the axes did not reach the path");
    master_.pass(std::chrono::milliseconds{10});
    drain();
  }
  master_.cycle()->count(false);
  master_.pass(2 * config_.period);
  master_.cycle()->count(true);
}

void CanRig::drain() {
  rings_.drain();
}

void CanRig::check() {
  if (motion_->phase() != motion::MotionPhase::kFollowing) {
    throw Disturbed(fmt::format("the axes left the path over CAN: {}", to_text(motion_->phase())));
  }
  for (std::size_t i = 0; i < config_.slaves.size(); ++i) {
    const auto report = master_.cycle()->node_report(i);
    if (report.lost + report.late + report.unsent > 0) throw Disturbed("a PDO was lost");
  }
}

}  // namespace driveline::bench
