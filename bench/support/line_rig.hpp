#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "support/timed_port.hpp"

namespace driveline::bench {

/// Frames take no time on the wire.
inline constexpr slaves::LineOptions kNoDelays{.delays = {std::chrono::nanoseconds{0}, std::chrono::nanoseconds{0}},
                                               .cable_delay = std::chrono::nanoseconds{0},
                                               .byte_time = std::chrono::nanoseconds{0}};

/// Telemetry rings of a line, whose content is not used.
class LineRings {
 public:
  explicit LineRings(std::size_t axes);
  [[nodiscard]] motion::SampleRings ends() noexcept { return {&lines_, &axes_}; }
  /// Empties them, as their reader would. One thread.
  void drain();

 private:
  rt::SpscRing<snapshot::LineSample> lines_;
  rt::SpscRing<snapshot::AxisSample> axes_;
};

/// Sines of 3 rad, each axis at its own speed, all from standstill at 0.
[[nodiscard]] trajectory::Interpolator sines(const std::vector<motion::AxisConfig>& axes,
                                             std::chrono::nanoseconds duration);

/// A line of `axes` MSD drives, each of them an axis.
[[nodiscard]] runtime::LineConfig describe_line(std::size_t axes, std::chrono::nanoseconds period);

/// A line of simulated MSD drives in this process and the master that runs them, composed by the runtime as from a line
/// description. Every axis follows its own sine, or waits for requests. Frames take no time on the wire: only computing
/// is measured.
class LineRig {
 public:
  static constexpr std::chrono::nanoseconds kPeriod = std::chrono::microseconds{125};

  /// `path_duration`: length of the path for bring_up(); not used by bring_up_single_axes().
  LineRig(rt::Clock& clock, std::size_t axes, std::chrono::nanoseconds path_duration,
          std::chrono::nanoseconds period = kPeriod);

  /// Takes the line to OP and all axes onto the path. The runner from `make_runner` runs the cycles and must leave the
  /// rings to drain(). Throws std::runtime_error on failure.
  void bring_up(const ecat_master::Master::MakeRunner& make_runner);
  /// Like bring_up(), but the axes are commanded by requests: takes the line to OP and all axes to standstill, enabled.
  void bring_up_single_axes(const ecat_master::Master::MakeRunner& make_runner);
  /// Empties the telemetry rings, as their reader would. One thread.
  void drain();
  /// Throws Disturbed if the axes have left the path, a single axis has failed, or process data have been lost since
  /// bring_up(): the figures would be invalid. On virtual time nothing can disturb it, so a retry is useless. Only
  /// while no cycle runs.
  void check();

  [[nodiscard]] TimedPort& port() noexcept { return port_; }
  [[nodiscard]] slaves::SimulatedLine& line() noexcept { return line_; }
  [[nodiscard]] ecat_master::Master& master() noexcept { return master_; }
  /// Only after bring_up().
  [[nodiscard]] motion::Motion& motion() noexcept { return *motion_; }
  /// Only after bring_up_single_axes().
  [[nodiscard]] motion::SingleAxes& single_axes() noexcept { return *single_axes_; }
  /// Memory in bytes that the master and the objects behind it have allocated since this line was created, without its
  /// path but with what the drives have allocated at their start. For single-threaded programs.
  [[nodiscard]] std::size_t heap_of_master() const;

 private:
  void configure();
  void make_motion();
  void to_operational(motion::MotionControl& motion, const ecat_master::Master::MakeRunner& make_runner);
  void count_from_here();
  /// Lets cycles run until `there()`; throws std::runtime_error with `failure` after 5 s.
  template <typename There>
  void pass_until(const There& there, const char* failure);
  void check_motion() const;

  rt::Clock& clock_;
  std::chrono::nanoseconds path_duration_;
  runtime::LineConfig config_;
  slaves::SimulatedLine line_;
  std::size_t heap_of_line_;  ///< heap in use after the line was created
  std::size_t heap_of_path_ = 0;
  TimedPort port_;
  LineRings rings_;
  std::unique_ptr<motion::Motion> motion_;
  std::unique_ptr<motion::SingleAxes> single_axes_;
  ecat_master::Master master_;
};

}  // namespace driveline::bench
