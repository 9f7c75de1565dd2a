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

constexpr std::size_t kStaged = 256;  ///< frames of a cycle, far more than there are

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

StagedCanPort::StagedCanPort(canopen::CanPort& inner) : inner_(inner) {
  arrived_.reserve(kStaged);
  sent_.reserve(kStaged);
  repeated_.reserve(kStaged);
}

void StagedCanPort::stage() {
  arrived_.erase(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(next_));
  next_ = 0;
  while (const auto frame = inner_.receive()) arrived_.push_back(*frame);
  statistics_ = inner_.statistics();
  staged_ = true;
}

double StagedCanPort::repeat_calls_ns() {
  repeated_ = sent_;
  sent_.clear();
  next_ = 0;
  canopen::CanPort& port = *this;
  const double begin = now_ns();
  while (const auto received = port.receive()) keep(*received);
  for (const auto& frame : repeated_) keep(port.send(frame));
  keep(port.statistics());
  return now_ns() - begin - reading_cost_ns();
}

void StagedCanPort::release() {
  staged_ = false;
  for (const auto& frame : sent_) {
    if (inner_.send(frame) != canopen::SendStatus::kSent) throw std::runtime_error("the bus did not take a frame");
  }
  sent_.clear();
}

canopen::SendStatus StagedCanPort::send(const canopen::Frame& frame) noexcept {
  if (!staged_) return inner_.send(frame);
  if (sent_.size() == sent_.capacity()) return canopen::SendStatus::kBusy;
  sent_.push_back(frame);
  return canopen::SendStatus::kSent;
}

std::optional<canopen::ReceivedFrame> StagedCanPort::receive() noexcept {
  if (next_ < arrived_.size()) return arrived_[next_++];
  return staged_ ? std::nullopt : inner_.receive();
}

bool StagedCanPort::wait_readable(nanoseconds deadline) noexcept {
  return next_ < arrived_.size() || inner_.wait_readable(deadline);
}

canopen::PortStatistics StagedCanPort::statistics() const noexcept {
  return staged_ ? statistics_ : inner_.statistics();
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
