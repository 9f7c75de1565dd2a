#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/canopen_master/can_cycle.hpp"
#include "driveline/motion/cycle/cycle_runner.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"

/// Axes on a simulated CAN bus on virtual time, under the cycle of the master, without its supervision.
namespace driveline::bus_test {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A port to a simulated bus that loses frames.
class LossyCanPort final : public canopen::CanPort, private slaves::can::Node {
 public:
  LossyCanPort(slaves::can::Bus& bus, rt::Clock& clock) : bus_(bus), clock_(clock) { bus.attach(*this); }

  [[nodiscard]] canopen::SendStatus send(const canopen::Frame& frame) noexcept override;
  [[nodiscard]] std::optional<canopen::ReceivedFrame> receive() noexcept override;
  bool wait_readable(nanoseconds deadline) noexcept override;
  [[nodiscard]] canopen::PortStatistics statistics() const noexcept override { return counters_; }

  /// Asked for every frame: whether it is lost.
  std::function<bool(const canopen::Frame&)> lose_sent;
  std::function<bool(const canopen::Frame&)> lose_received;
  /// Asked for every frame: whether the adapter is too busy to take it.
  std::function<bool(const canopen::Frame&)> refuse;
  /// A sum over all frames on the bus and their times.
  [[nodiscard]] std::uint64_t sum() const noexcept { return sum_; }

 private:
  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const canopen::Frame& frame, nanoseconds now) override;
  void transmitted(const canopen::Frame& frame, nanoseconds now) override { add(frame, now); }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }
  void add(const canopen::Frame& frame, nanoseconds now) noexcept;

  slaves::can::Bus& bus_;
  rt::Clock& clock_;
  slaves::can::Controller* controller_ = nullptr;
  std::deque<canopen::ReceivedFrame> arrived_;
  canopen::PortStatistics counters_;
  std::uint64_t sum_ = 0xCBF2'9CE4'8422'2325;
};

/// How the axes are operated.
struct CanAxesOptions {
  std::size_t axes = 8;
  nanoseconds period = milliseconds{2};
  slaves::msd::Variant variant = slaves::msd::Variant::kMsd;
  std::vector<motion::StartupSdo> startup{};           ///< of every drive, besides those of its axis
  std::vector<slaves::msd::MachineSwitch> switches{};  ///< of every drive
  bool profile = false;                                ///< PDOs of the profile modes, too
  bool velocity = false;                               ///< the actual velocity with SYNC, in TPDO 3
  bool single_axes = false;                            ///< each axis by its requests, instead of along the path
  std::optional<double> setpoint_delay_cycles{};       ///< none: can_setpoint_delay_cycles()
  trajectory::AxisLimits limits{200.0, 2000.0};        ///< of every axis
  std::uint32_t max_lost_cycles = 8;                   ///< gap that the motion bridges
  motion::SetpointFeed* feed = nullptr;                ///< with `single_axes`
};

/// The line: drives with the node-IDs from 3 on, and the master. Motion and requests as on EtherCAT.
class CanAxisLine {
 public:
  explicit CanAxisLine(const CanAxesOptions& options);

  /// Waits for the boot-up of the drives, configures them, and starts them. Empty: done; otherwise what failed.
  [[nodiscard]] std::string configure();
  /// Makes the motion and starts the cycle.
  void start_cycle();
  /// Runs cycles for `duration`; stores all samples.
  void run(nanoseconds duration);
  /// Runs exactly one cycle.
  void cycle() { run(nanoseconds{1}); }
  /// Runs cycles until the motion is in `phase`, at most for `limit`; false: it did not get there.
  [[nodiscard]] bool run_until(motion::MotionPhase phase, nanoseconds limit);
  /// Advances drives and bus without a master.
  void leave_alone(nanoseconds duration);

  [[nodiscard]] slaves::msd::DriveCore& drive(std::size_t axis) noexcept { return drives_[axis]->core(); }
  [[nodiscard]] std::size_t size() const noexcept { return drives_.size(); }
  [[nodiscard]] canopen::CanCycle& can_cycle() noexcept { return *cycle_; }
  [[nodiscard]] motion::Motion& motion() noexcept { return *motion_; }
  [[nodiscard]] motion::SingleAxes& single_axes() noexcept { return *single_axes_; }
  [[nodiscard]] const motion::CycleStatistics& statistics() const noexcept { return cycle_->statistics(); }
  [[nodiscard]] slaves::can::Bus& bus() noexcept { return bus_; }
  [[nodiscard]] LossyCanPort& port() noexcept { return port_; }
  [[nodiscard]] const canopen::MasterPlan& plan() const noexcept { return plan_; }
  [[nodiscard]] canopen::AcyclicChannel& channel() noexcept { return channel_; }
  [[nodiscard]] motion::InlineRunner& runner() noexcept { return *runner_; }
  [[nodiscard]] motion::AxisConfig axis(std::size_t place) const;

  rt::VirtualClock clock;
  std::vector<snapshot::AxisSample> axis_samples;
  std::vector<snapshot::LineSample> line_samples;
  bool samples = true;

  /// The path of every axis is a raised cosine of this length; that of axis 0 has an amplitude of 1 rad, the others
  /// have a little less.
  static constexpr double kPathSeconds = 0.4;

 private:
  [[nodiscard]] std::string configure(std::size_t axis);
  [[nodiscard]] motion::MotionControl& make_motion();
  void drain();

  CanAxesOptions options_;
  slaves::can::Bus bus_;
  std::vector<std::unique_ptr<slaves::msd::MsdCanDrive>> drives_;
  LossyCanPort port_{bus_, clock};
  canopen::MasterPlan plan_;
  canopen::AcyclicChannel channel_;
  rt::SpscRing<snapshot::LineSample> line_ring_{1024};
  rt::SpscRing<snapshot::AxisSample> axis_ring_{16384};
  std::unique_ptr<motion::Motion> motion_;
  std::unique_ptr<motion::SingleAxes> single_axes_;
  std::optional<canopen::PdoImage> image_;
  std::unique_ptr<canopen::CanCycle> cycle_;
  std::unique_ptr<motion::InlineRunner> runner_;
};

}  // namespace driveline::bus_test
