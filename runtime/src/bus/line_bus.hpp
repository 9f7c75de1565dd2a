#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "bus/line_motion.hpp"
#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/motion/cycle/cycle_trace.hpp"
#include "driveline/motion/cycle/sample_rings.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/record/run_report.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "record/fault_records.hpp"

namespace driveline::runtime {

/// What a run hands to the cycle; everything must outlive it.
struct CycleParts {
  motion::MotionControl* motion = nullptr;  ///< moves the axes; null: process data are exchanged without motion
  motion::SampleRings rings;                ///< receive the samples
  motion::TaskSchedule* tasks = nullptr;    ///< null: there are no tasks
  FaultRecords* records = nullptr;          ///< records the cycles around faults; never null
  motion::CycleTrace* trace = nullptr;      ///< null: the cycle is not traced
};

/// The bus of a line as a run uses it: brings the line up, exchanges process data, watches the line, and takes it down.
/// The functions are called in their order, on the thread that owns the line.
class LineBus {
 public:
  /// Receives what happens on the bus.
  struct Listener {
    LineMotion::Tell tell;                ///< events, in their order
    std::function<void()> slaves_change;  ///< the slaves are known, or their states have changed
  };

  virtual ~LineBus() = default;

  /// Sets the listener. Call first.
  virtual void listen(Listener listener) = 0;
  /// Returns the line description, which bring_up() completes with what it finds on the line.
  [[nodiscard]] virtual LineConfig& config() noexcept = 0;
  /// Returns the clock of the bus.
  [[nodiscard]] virtual rt::Clock& clock() noexcept = 0;
  /// Whether the bus runs on virtual time.
  [[nodiscard]] virtual bool virtual_time() const noexcept = 0;
  /// Returns the state of the line: "INIT", "SAFEOP", "OP", or the one to which it has fallen.
  [[nodiscard]] virtual const std::string& state() const noexcept = 0;
  /// Whether operation has begun and the cycle runs.
  [[nodiscard]] virtual bool in_operation() const noexcept = 0;

  /// Makes ready what the line needs on this machine. Nothing is sent. Errors: it is not available.
  [[nodiscard]] virtual Result<void> prepare() = 0;
  /// Finds and configures the slaves, and completes the axes with the facts of their drives. `force`: takes over a line
  /// that another master controls. Errors: the line cannot be used as described.
  [[nodiscard]] virtual Result<void> bring_up(bool force) = 0;
  /// Returns the process data by name and the copies between them. Call after bring_up().
  [[nodiscard]] virtual const NamedProcessData& process_data() const noexcept = 0;
  /// Returns the axes of the motion, in the order of the description. Call after bring_up().
  [[nodiscard]] virtual std::vector<motion::Axis> make_axes() const = 0;
  /// Returns the age of the inputs of a slave when they arrive. `slave`: number of its [[slave]]. Call after
  /// bring_up().
  [[nodiscard]] virtual std::chrono::nanoseconds input_age(std::size_t slave) const = 0;
  /// Whether the drive of an axis of the description does not report its velocity, so that its samples get it from the
  /// positions. Call after bring_up().
  [[nodiscard]] virtual bool lacks_velocity(std::size_t /*axis*/) const { return false; }
  /// Starts the cycle and takes all slaves to operation. Errors: the thread of the cycle cannot start (kMachine), a
  /// slave does not get there (kLine).
  [[nodiscard]] virtual Result<void> start(const CycleParts& parts) = 0;
  /// Starts the services of the line to this machine, and tells of them. Errors: they are not available.
  [[nodiscard]] virtual Result<void> start_services() = 0;

  /// Waits while the cycle runs.
  virtual void pass(std::chrono::nanoseconds duration) = 0;
  /// Whether the cycles from now on count in the figures of the report.
  virtual void count(bool on) noexcept = 0;
  /// Begins to watch the line. `motion` must outlive the bus; null: no axes are moved.
  virtual void begin_operation(LineMotion* motion) = 0;
  /// Looks once at the line and tells what has changed; recovers slaves, which may take time. False: the run cannot
  /// continue.
  [[nodiscard]] virtual bool look() = 0;
  /// Reads figures for the report that need requests to the slaves, which takes time. Call at the end of operation.
  virtual void read_figures() = 0;
  /// Ends the watch: tells what look() has not told.
  virtual void end_operation() = 0;
  /// Whether anybody on the bus answers.
  [[nodiscard]] virtual bool answers() noexcept = 0;

  /// Ends the services, and tells of them and of foreign frames.
  virtual void stop_services() = 0;
  /// Ends the cycle and takes all slaves to their first state. False: that failed, which was told.
  [[nodiscard]] virtual bool take_down() = 0;

  /// Returns the slaves for the telemetry. `owners` of the axes, by axis; `now`: reads them at once. Null: nothing has
  /// changed, or they are not known yet.
  [[nodiscard]] virtual const snapshot::FeedCondition* slaves(const std::vector<std::string>& owners, bool now) = 0;
  /// Sets what the bus knows of the run in its report. Call after take_down().
  virtual void report(RunReport& report) = 0;

 protected:
  LineBus() = default;
  LineBus(const LineBus&) = delete;
  LineBus& operator=(const LineBus&) = delete;
};

}  // namespace driveline::runtime
