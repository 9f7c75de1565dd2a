#include "support/stop_cost.hpp"

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "support/line_rig.hpp"
#include "support/realtime.hpp"
#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

using motion::AxisCommand;
using motion::AxisRequest;
using motion::PlcopenState;
using motion::RequestPhase;

/// The axes accelerate for 4 ms, so a turn moves them by some hundredths of a rad.
constexpr double kVelocity = 4.0;         // rad/s
constexpr double kAcceleration = 1000.0;  // rad/s^2
constexpr double kFarRad = 100.0;         // not reached before the stop
constexpr int kSpeedUpCycles = 40;
constexpr int kMovingCycles = 16;
/// To standstill in 32 cycles; the cycle takes the 256 requests that the queue holds, four at a time, in 64.
constexpr int kRestCycles = 80;
constexpr int kRequests = 10'000;

/// Runs cycles back to back in the caller's thread, one by one, and measures the master's part of each.
class CountedRunner final : public motion::CycleRunner {
 public:
  CountedRunner(ecat_master::CyclicCore& core, rt::Clock& clock, LineRig& rig)
      : core_(core), clock_(clock), rig_(rig), timer_(clock, LineRig::kPeriod) {}

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override { return {}; }
  void pass(std::chrono::nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      cycle();
    } while (clock_.now() < end);
    rest();
  }
  void stop() override {}

  /// Cost of one cycle, in ns.
  double cycle() {
    rig_.port().reset(true);
    const double begin = now_ns();
    core_.cycle(timer_.wait_next());
    const double whole = now_ns() - begin - reading_cost_ns();
    const double cost = whole - rig_.port().overhead_ns() - rig_.port().inside_ns();
    rig_.drain();
    return cost;
  }
  void rest() { rests_.take_when_due(now_ns()); }

 private:
  ecat_master::CyclicCore& core_;
  rt::Clock& clock_;
  LineRig& rig_;
  rt::CycleTimer timer_;
  Rests rests_;
};

void require(bool condition, const char* failure) {
  if (!condition) throw std::runtime_error(failure);
}

/// A line whose axes move, stop together, and move back.
class StoppedLine {
 public:
  StoppedLine(std::size_t axes, StopLoad load)
      : axes_(axes), load_(load), rig_(clock_, axes, std::chrono::nanoseconds{0}) {
    rig_.bring_up_single_axes([this](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
      auto runner = std::make_unique<CountedRunner>(core, clock_, rig_);
      runner_ = runner.get();
      return runner;
    });
  }

  void turn(StopCosts& costs) {
    start_moves();
    cycles(kSpeedUpCycles);
    std::vector<double> moving;
    for (int i = 0; i < kMovingCycles; ++i) moving.push_back(runner_->cycle());
    costs.moving.add_turn(moving);
    if (load_ == StopLoad::kRequests) fill_queue();
    std::vector<std::uint64_t> stops;
    for (std::size_t i = 0; i < axes_; ++i) stops.push_back(rig_.single_axes().submit(i, ask(AxisCommand::kStop)));
    expect_waiting_moves(RequestPhase::kWaiting, "a move does not wait before the stop");
    costs.stopping.add_turn({runner_->cycle()});
    for (std::size_t i = 0; i < axes_; ++i)
      require(rig_.single_axes().axis_report(i).state == PlcopenState::kStopping, "an axis was not stopped at once");
    expect_waiting_moves(RequestPhase::kAborted, "a move goes on after the stop");
    cycles(kRestCycles);
    for (const auto stop : stops)
      require(rig_.single_axes().report(stop).phase == RequestPhase::kDone, "an axis is not at rest after its stop");
    for (std::size_t i = 0; i < axes_; ++i) rig_.single_axes().submit_in_cycle(i, ask(AxisCommand::kReleaseStop));
    runner_->rest();
  }
  void check() { rig_.check(); }

 private:
  static AxisRequest ask(AxisCommand command, double target = 0.0) {
    AxisRequest request;
    request.command = command;
    request.target_si = target;
    if (command == AxisCommand::kMoveRelative) request.velocity_si = kVelocity;
    if (command != AxisCommand::kSetOverride) request.acceleration_si = kAcceleration;
    return request;
  }
  /// Starts a move of each axis in the other direction than in the turn before.
  void start_moves() {
    direction_ = -direction_;
    waiting_.clear();
    for (std::size_t i = 0; i < axes_; ++i) {
      rig_.single_axes().submit_in_cycle(i, ask(AxisCommand::kMoveRelative, direction_ * kFarRad));
      if (load_ == StopLoad::kNothing) continue;
      auto next = ask(AxisCommand::kMoveRelative, direction_);
      next.buffer = motion::BufferMode::kBuffered;
      waiting_.push_back(rig_.single_axes().submit_in_cycle(i, next));
    }
  }
  void fill_queue() {
    std::uint64_t last = 1;
    for (int i = 0; i < kRequests; ++i)
      last = rig_.single_axes().submit(static_cast<std::size_t>(i) % axes_, ask(AxisCommand::kSetOverride, 1.0));
    require(last == 0, "the queue of requests is not full");
  }
  void expect_waiting_moves(RequestPhase phase, const char* failure) {
    for (const auto move : waiting_) require(rig_.single_axes().report(move).phase == phase, failure);
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) runner_->cycle();
  }

  std::size_t axes_;
  StopLoad load_;
  rt::VirtualClock clock_{};
  LineRig rig_;
  CountedRunner* runner_ = nullptr;  ///< belongs to the master
  double direction_ = 1.0;
  std::vector<std::uint64_t> waiting_{};  ///< the moves that wait for the present ones to end
};

}  // namespace

StopCosts measure_stops(std::size_t axes, StopLoad load, int turns) {
  StoppedLine line(axes, load);
  StopCosts costs;
  for (int i = 0; i < turns; ++i) line.turn(costs);
  line.check();
  return costs;
}

}  // namespace driveline::bench
