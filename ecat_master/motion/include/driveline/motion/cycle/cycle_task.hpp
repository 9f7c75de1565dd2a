#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Input of a task in the cycle; valid until update() returns.
struct TaskCycle {
  std::int64_t cycle = 0;                       ///< number of the cycle on the grid, skipped periods included
  std::chrono::nanoseconds grid{};              ///< grid time of the cycle on the clock of the master
  std::optional<std::uint64_t> system_time_ns;  ///< grid time as DC system time; none: no distributed clocks
  std::int64_t missed = 0;                      ///< periods of the line that were skipped since the task's last call
  /// Grid time since the task's last call; 0 at the first.
  std::chrono::nanoseconds elapsed{};
  std::span<const Axis> axes;  ///< axes of the line; Axis::inputs() in SI units. Empty: the line has no axes
  /// Last setpoints of the axes, in SI units; before the motion they are those of the previous cycle.
  std::span<const trajectory::AxisSetpoint> setpoints;
  std::span<const std::byte> inputs;  ///< inputs of the process image
  std::span<const bool> valid;        ///< by slave: inputs are from the last exchange that was due; false: stale
  std::span<std::byte> outputs;       ///< outputs of the process image; the motion overwrites those of axes
};

/// Work of the application in the cycle: a controller, logic between slaves, a measurement.
class CycleTask {
 public:
  virtual ~CycleTask() = default;
  /// Called in the cycle, on its thread: no exceptions, allocation, locks or waiting. \rtsafe
  virtual void update(const TaskCycle& cycle) noexcept = 0;

 protected:
  CycleTask() = default;
  /// Copying is for implementations only: tasks are used by reference.
  CycleTask(const CycleTask&) = default;
  CycleTask& operator=(const CycleTask&) = default;
};

/// Cycles in which a task runs, and its order in them.
struct TaskTiming {
  /// Order within a cycle.
  enum class Order : std::uint8_t {
    kBeforeMotion,  ///< after the inputs; its commands are sent with the next frame
    kAfterMotion,   ///< after the setpoints of this cycle are known
  };
  std::uint32_t divider = 1;  ///< runs in every n-th cycle, at least 1
  std::uint32_t phase = 0;    ///< remainder of the cycle numbers; below `divider`
  Order order = Order::kBeforeMotion;
};

/// Run times of a task since the start; to be read while the cycle is stopped.
struct TaskFigures {
  std::uint64_t calls = 0;
  rt::Histogram cost;  ///< run time per call
  /// Heap and lock functions that the task has called; counted if the library was built with DRIVELINE_TASK_GUARD (the
  /// default in a debug build), else 0.
  std::uint64_t forbidden_calls = 0;
};

/// The tasks of a line, in the order in which they were added. A task whose cycle was skipped runs in the next cycle.
class TaskSchedule {
 public:
  /// `task` must outlive the schedule. To be called before the cycle runs.
  /// @throws std::invalid_argument if the divider is 0 or the phase is not below the divider.
  void add(CycleTask& task, TaskTiming timing);

  // Functions for the cycle. \rtsafe
  /// To be called at the start of a cycle.
  void begin(const rt::CycleStart& start) noexcept;
  /// Runs the due tasks of this order. `now`: the part of their input that is common to all. `period`: cycle time of
  /// the line.
  void run(TaskTiming::Order order, TaskCycle now, std::chrono::nanoseconds period, rt::Clock& clock) noexcept;

  /// Figures of a task, in the order of add(). To be read while the cycle is stopped.
  [[nodiscard]] const TaskFigures& figures(std::size_t task) const noexcept { return entries_[task]->figures; }
  /// Number of tasks. \rtsafe
  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }

 private:
  struct Entry {
    CycleTask* task;
    TaskTiming timing;
    TaskFigures figures{};
    std::int64_t turn = 0;  ///< cycle number of its last run divided by the divider
    std::int64_t last = 0;  ///< cycle of the last call
    std::int64_t missed = 0;
    bool due = false;
  };

  std::vector<std::unique_ptr<Entry>> entries_;
};

}  // namespace driveline::motion
