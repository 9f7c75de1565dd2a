#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "driveline/ecat_master/axis/axis_compensation.hpp"
#include "driveline/ecat_master/axis/feed_forward.hpp"
#include "driveline/ecat_master/cyclic/motion.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/slaves/line/line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::bus_test {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A simulated line of drives on a virtual clock.
class DriveLine {
 public:
  /// Wired as a plain line, or as `wiring` says; drive n is then the n-th of the wiring, not of the line. The first one
  /// stands at `first_position_rad` when it is switched on, the others not far from it.
  explicit DriveLine(std::size_t drives, const slaves::SlaveOptions& options = {},
                     const slaves::LineOptions& line_options = {}, std::optional<slaves::Wiring> wiring = std::nullopt,
                     slaves::msd::Variant variant = slaves::msd::Variant::kMsd, double first_position_rad = 0.0,
                     const std::vector<slaves::msd::MachineSwitch>& switches = {});

  rt::VirtualClock clock;

  [[nodiscard]] slaves::Line& line() noexcept { return *line_; }
  [[nodiscard]] std::size_t size() const noexcept { return drives_.size(); }
  [[nodiscard]] slaves::msd::DriveCore& drive(std::size_t position) noexcept { return *drives_[position]; }
  [[nodiscard]] slaves::Slave& slave(std::size_t position) noexcept { return line_->slave(position); }
  [[nodiscard]] wire::AlState state(std::size_t position) noexcept { return slave(position).state(); }
  [[nodiscard]] wire::AlStatusCode al_status_code(std::size_t position);
  [[nodiscard]] bool all_in(wire::AlState state) noexcept;
  /// No master: time passes for the drives alone.
  void leave_alone(nanoseconds duration);

 private:
  std::vector<slaves::msd::DriveCore*> drives_;
  std::unique_ptr<slaves::Line> line_;
};

/// How the drives of a line are run.
struct RunOptions {
  nanoseconds period = microseconds{125};
  ecat_master::ReceiveStrategy receive{};  ///< how the cycle waits for its answers
  ecat_master::cia402::Mode mode = ecat_master::cia402::Mode::kCyclicPosition;
  bool repeat = false;
  bool relative = false;  ///< the path, to where the axes stand
  nanoseconds enable_timeout = std::chrono::seconds{2};
  nanoseconds state_timeout = std::chrono::seconds{10};
  double amplitude_rad = 1.0;  ///< of axis 0
  ecat_master::LayoutSettings layout{};
  std::size_t groups = 1;                                     ///< drive n belongs to group n modulo this
  bool every_third_without_lrw = false;                       ///< drives 1, 4, 7 ... take no LRW
  std::size_t acyclic_bytes = 0;                              ///< what the process data leave
  slaves::msd::Variant variant = slaves::msd::Variant::kMsd;  ///< expected
  ecat_master::CycleTask* task = nullptr;
  ecat_master::TaskTiming::Order task_order = ecat_master::TaskTiming::Order::kBeforeMotion;
  std::vector<std::size_t> hot_connect{};  ///< these drives
  ecat_master::FlightRecorder* recorder = nullptr;
  ecat_master::CycleTrace* trace = nullptr;
  /// Process data handed from slave to slave, in the image of the line.
  std::function<std::vector<ecat_master::ProcessDataCopy>(const ecat_master::Master&)> copies{};
  ecat_master::LossPolicy on_loss = ecat_master::LossPolicy::kStop;  ///< of every axis
  ecat_master::LatePolicy late = ecat_master::LatePolicy::kStay;     ///< of the path
  std::vector<ecat_master::StartupSdo> startup{};                    ///< of every drive, behind its own
  bool plan_serials = false;                      ///< the plan names the serial number of every drive
  std::optional<double> setpoint_delay_cycles{};  ///< of every axis
  /// PDOs of every axis; none: axis_pdo_configuration()
  std::optional<ecat_master::PdoConfiguration> pdos{};
  bool single_axes = false;                        ///< each axis by itself (SingleAxes), instead of along the path
  bool adds_offsets = false;                       ///< AxisConfig::adds_offsets of every axis
  bool follow_bit = true;                          ///< AxisConfig::follow_bit of every axis
  std::optional<std::uint32_t> supported_modes{};  ///< AxisConfig::supported_modes of every axis
  std::optional<trajectory::PositionRange> software_limits{};  ///< AxisConfig::software_limits of every axis
  std::optional<double> max_torque{};                          ///< AxisConfig::max_torque of every axis
  nanoseconds homing_timeout = std::chrono::minutes{2};        ///< of single axes
  nanoseconds target_timeout = std::chrono::minutes{2};        ///< of single axes
  std::optional<double> following_error_window{};              ///< AxisConfig::following_error_window of every axis
  /// AxisConfig::range_min and range_max of every axis
  std::int32_t range_min = 0;
  std::int32_t range_max = 0;
  std::optional<double> modulo{};           ///< AxisConfig::modulo of every axis
  ecat_master::FeedForward feed_forward{};  ///< of every axis
  bool reversed = false;                    ///< AxisConfig::reversed of every axis
  double velocity_count = 0.0;              ///< AxisConfig::velocity_count of every axis
  /// Of every axis, which has what it leaves of the limits.
  std::shared_ptr<const ecat_master::CompensationSettings> compensation{};
  bool knows_torques = true;          ///< every axis has an inertia and a velocity gain
  bool accept_swapped_ports = false;  ///< IN and OUT of a slave may be swapped
  bool samples = true;                ///< LineOperation::axis_samples and line_samples are taken
  /// With `single_axes`, behind the axes of the drives.
  std::vector<ecat_master::AxisConfig> virtual_axes{};
  ecat_master::SetpointFeed* feed = nullptr;  ///< with `single_axes`, of the first axes
};

/// A master that runs all drives of a line along a path of raised cosines, each axis with its own amplitude; composed
/// as the runtime does it with a line description, but not supervised.
class LineOperation {
 public:
  /// The path of every axis is one raised cosine of this length.
  static constexpr double kPathSeconds = 0.4;

  LineOperation(DriveLine& drives, port::Port& port, const RunOptions& options = {});
  explicit LineOperation(DriveLine& drives, const RunOptions& options = {})
      : LineOperation(drives, drives.line(), options) {}

  /// The line as the runtime knows it; the rest of `options` is not for a description.
  [[nodiscard]] static runtime::LineConfig describe(std::size_t drives, const RunOptions& options);
  [[nodiscard]] static ecat_master::SlavePlan plan(std::size_t position, const RunOptions& options);
  [[nodiscard]] std::vector<ecat_master::SlavePlan> plans() const;
  [[nodiscard]] static ecat_master::AxisConfig axis(std::size_t position, const RunOptions& options);

  /// scan, configure; every step must succeed before the next is tried.
  [[nodiscard]] ecat_master::Result<void> to_safe_op();
  /// Builds the motion and starts cycling in SAFEOP, with an InlineRunner unless told otherwise.
  void start_cycle(ecat_master::Master::MakeRunner make_runner = {});
  [[nodiscard]] ecat_master::Result<void> to_op();
  /// Everything, with the motion requested.
  [[nodiscard]] ecat_master::Result<void> to_motion();

  /// Cycles for `duration`; keeps all samples.
  void run(nanoseconds duration);
  /// Exactly one cycle.
  void cycle() { run(nanoseconds{1}); }
  /// Cycles until the motion is in `phase`, at most for `limit`; false when it is not.
  [[nodiscard]] bool run_until(ecat_master::MotionPhase phase, nanoseconds limit);

  [[nodiscard]] ecat_master::Master& master() noexcept { return *master_; }
  [[nodiscard]] ecat_master::Motion& motion() noexcept { return *motion_; }
  /// With RunOptions::single_axes.
  [[nodiscard]] ecat_master::SingleAxes& single_axes() noexcept { return *single_axes_; }
  [[nodiscard]] const ecat_master::CycleStatistics& statistics() noexcept { return master_->core()->statistics(); }

  std::vector<snapshot::AxisSample> axis_samples;
  std::vector<snapshot::LineSample> line_samples;

 private:
  [[nodiscard]] ecat_master::Master::Settings master_settings() const;
  [[nodiscard]] ecat_master::MotionControl& make_motion();
  void drain();

  DriveLine& drives_;
  port::Port& port_;
  RunOptions options_;
  runtime::LineConfig config_;
  rt::SpscRing<snapshot::LineSample> line_ring_;
  rt::SpscRing<snapshot::AxisSample> axis_ring_;
  std::unique_ptr<ecat_master::Motion> motion_;
  std::unique_ptr<ecat_master::SingleAxes> single_axes_;
  ecat_master::TaskSchedule tasks_;
  std::unique_ptr<ecat_master::Master> master_;
};

/// For assertions: the sentence of an error, empty without one.
template <typename T>
[[nodiscard]] std::string sentence(const ecat_master::Result<T>& result) {
  return result ? std::string{} : ecat_master::describe(result.error());
}

}  // namespace driveline::bus_test
