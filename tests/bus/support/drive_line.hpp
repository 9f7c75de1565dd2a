#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/motion/axis/axis_compensation.hpp"
#include "driveline/motion/axis/feed_forward.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "support/motion_trace.hpp"

namespace driveline::bus_test {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A simulated line of drives on a virtual clock.
class DriveLine {
 public:
  /// Wired as a plain line, or according to `wiring`; drive n is then the n-th of the wiring, not of the line. At
  /// power-on the first drive is at `first_position_rad`, the others are close to it.
  explicit DriveLine(std::size_t drives, const slaves::SlaveOptions& options = {},
                     const slaves::LineOptions& line_options = {}, std::optional<slaves::Wiring> wiring = std::nullopt,
                     slaves::msd::Variant variant = slaves::msd::Variant::kMsd, double first_position_rad = 0.0,
                     const std::vector<slaves::msd::MachineSwitch>& switches = {});

  rt::VirtualClock clock;

  [[nodiscard]] slaves::SimulatedLine& line() noexcept { return *line_; }
  [[nodiscard]] std::size_t size() const noexcept { return drives_.size(); }
  [[nodiscard]] slaves::msd::DriveCore& drive(std::size_t position) noexcept { return *drives_[position]; }
  [[nodiscard]] slaves::Slave& slave(std::size_t position) noexcept { return line_->slave(position); }
  [[nodiscard]] wire::AlState state(std::size_t position) noexcept { return slave(position).state(); }
  [[nodiscard]] wire::AlStatusCode al_status_code(std::size_t position);
  [[nodiscard]] bool all_in(wire::AlState state) noexcept;
  /// Advances the time of the drives alone, without a master.
  void leave_alone(nanoseconds duration);

 private:
  std::vector<slaves::msd::DriveCore*> drives_;
  std::unique_ptr<slaves::SimulatedLine> line_;
};

/// How the drives of a line are operated.
struct RunOptions {
  nanoseconds period = microseconds{125};
  ecat_master::ReceiveStrategy receive{};  ///< waiting strategy of the cycle for its answers
  motion::cia402::Mode mode = motion::cia402::Mode::kCyclicPosition;
  bool repeat = false;
  bool relative = false;  ///< the path is relative to the initial positions
  nanoseconds enable_timeout = std::chrono::seconds{2};
  nanoseconds state_timeout = std::chrono::seconds{10};
  double amplitude_rad = 1.0;  ///< amplitude of axis 0
  ecat_master::LayoutSettings layout{};
  std::size_t groups = 1;                                     ///< drive n belongs to group n modulo this
  bool every_third_without_lrw = false;                       ///< drives 1, 4, 7 ... take no LRW
  std::size_t acyclic_bytes = 0;                              ///< bytes that the process data leave for acyclic frames
  slaves::msd::Variant variant = slaves::msd::Variant::kMsd;  ///< expected variant
  motion::CycleTask* task = nullptr;
  motion::TaskTiming::Order task_order = motion::TaskTiming::Order::kBeforeMotion;
  std::vector<std::size_t> hot_connect{};  ///< drives of a hot-connect group
  motion::FlightRecorder* recorder = nullptr;
  motion::CycleTrace* trace = nullptr;
  /// Process data copied from slave to slave, in the image of the line.
  std::function<std::vector<motion::ProcessDataCopy>(const ecat_master::Master&)> copies{};
  motion::LossPolicy on_loss = motion::LossPolicy::kStop;  ///< loss policy of every axis
  motion::LatePolicy late = motion::LatePolicy::kStay;     ///< late policy of the path
  std::uint32_t max_lost_cycles = 8;                       ///< LineConfig::max_lost_cycles
  std::vector<motion::StartupSdo> startup{};               ///< start-up SDOs of every drive, after its own
  bool plan_serials = false;                               ///< the plan names the serial number of every drive
  std::optional<double> setpoint_delay_cycles{};           ///< setpoint delay of every axis
  /// PDOs of every axis; none: axis_pdo_configuration()
  std::optional<motion::PdoConfiguration> pdos{};
  bool single_axes = false;   ///< each axis is commanded individually (SingleAxes), instead of along the path
  bool adds_offsets = false;  ///< AxisConfig::adds_offsets of every axis
  bool follow_bit = true;     ///< AxisConfig::follow_bit of every axis
  std::optional<std::uint32_t> supported_modes{};              ///< AxisConfig::supported_modes of every axis
  std::optional<trajectory::PositionRange> software_limits{};  ///< AxisConfig::software_limits of every axis
  std::optional<double> max_torque{};                          ///< AxisConfig::max_torque of every axis
  nanoseconds homing_timeout = std::chrono::minutes{2};        ///< with `single_axes`
  nanoseconds target_timeout = std::chrono::minutes{2};        ///< with `single_axes`
  std::optional<double> following_error_window{};              ///< AxisConfig::following_error_window of every axis
  /// AxisConfig::range_min and range_max of every axis
  std::int32_t range_min = 0;
  std::int32_t range_max = 0;
  std::optional<double> modulo{};      ///< AxisConfig::modulo of every axis
  motion::FeedForward feed_forward{};  ///< feed-forward of every axis
  bool reversed = false;               ///< AxisConfig::reversed of every axis
  double velocity_count = 0.0;         ///< AxisConfig::velocity_count of every axis
  /// Compensation of every axis, which reduces the limits left for its motions.
  std::shared_ptr<const motion::CompensationSettings> compensation{};
  bool knows_torques = true;          ///< every axis has an inertia and a velocity gain
  bool accept_swapped_ports = false;  ///< IN and OUT of a slave may be swapped
  bool samples = true;                ///< LineOperation::axis_samples and line_samples are taken
  /// With `single_axes`: axes that follow those of the drives.
  std::vector<motion::AxisConfig> virtual_axes{};
  motion::SetpointFeed* feed = nullptr;  ///< with `single_axes`: feed of the first axes
};

/// A master that moves all drives of a line along a path of raised cosines, each axis with its own amplitude; composed
/// as the runtime does it from a line description, but not supervised.
class LineOperation {
 public:
  /// The path of every axis is a single raised cosine of this length.
  static constexpr double kPathSeconds = 0.4;

  LineOperation(DriveLine& drives, port::Port& port, const RunOptions& options = {});
  explicit LineOperation(DriveLine& drives, const RunOptions& options = {})
      : LineOperation(drives, drives.line(), options) {}

  /// Description of the line for the runtime; other `options` do not belong to a description.
  [[nodiscard]] static runtime::LineConfig describe(std::size_t drives, const RunOptions& options);
  [[nodiscard]] static ecat_master::SlavePlan plan(std::size_t position, const RunOptions& options);
  [[nodiscard]] std::vector<ecat_master::SlavePlan> plans() const;
  [[nodiscard]] static motion::AxisConfig axis(std::size_t position, const RunOptions& options);

  /// Scans and configures the line; every step must succeed before the next is tried.
  [[nodiscard]] ecat_master::Result<void> to_safe_op();
  /// Builds the motion and starts cycling in SAFEOP, by default with an InlineRunner.
  void start_cycle(ecat_master::Master::MakeRunner make_runner = {});
  [[nodiscard]] ecat_master::Result<void> to_op();
  /// Executes all steps and requests the motion.
  [[nodiscard]] ecat_master::Result<void> to_motion();

  /// Runs cycles for `duration`; stores all samples.
  void run(nanoseconds duration);
  /// Runs exactly one cycle.
  void cycle() { run(nanoseconds{1}); }
  /// Runs cycles until the motion is in `phase`, at most for `limit`; false: it did not get there.
  [[nodiscard]] bool run_until(motion::MotionPhase phase, nanoseconds limit);

  [[nodiscard]] ecat_master::Master& master() noexcept { return *master_; }
  [[nodiscard]] motion::Motion& motion() noexcept { return *motion_; }
  /// Only with RunOptions::single_axes.
  [[nodiscard]] motion::SingleAxes& single_axes() noexcept { return *single_axes_; }
  [[nodiscard]] const motion::CycleStatistics& statistics() noexcept { return master_->core()->statistics(); }

  std::vector<snapshot::AxisSample> axis_samples;
  std::vector<snapshot::LineSample> line_samples;

 private:
  [[nodiscard]] ecat_master::Master::Settings master_settings() const;
  [[nodiscard]] motion::MotionControl& make_motion();
  void drain();
  void trace();

  DriveLine& drives_;
  MotionTrace trace_;
  bool traced_ = false;  ///< false: another thread steps the drives
  port::Port& port_;
  RunOptions options_;
  runtime::LineConfig config_;
  rt::SpscRing<snapshot::LineSample> line_ring_;
  rt::SpscRing<snapshot::AxisSample> axis_ring_;
  std::unique_ptr<motion::Motion> motion_;
  std::unique_ptr<motion::SingleAxes> single_axes_;
  motion::TaskSchedule tasks_;
  std::unique_ptr<ecat_master::Master> master_;
};

/// For assertions: the sentence of an error; empty: no error.
template <typename T>
[[nodiscard]] std::string sentence(const ecat_master::Result<T>& result) {
  return result ? std::string{} : ecat_master::describe(result.error());
}

}  // namespace driveline::bus_test
