#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// What a task in the cycle is given. Everything in it is of this cycle and may be used until update() returns.
struct TaskCycle {
  std::int64_t cycle = 0;                       ///< number of the cycle on the grid; skipped periods are counted too
  std::chrono::nanoseconds grid{};              ///< grid time of the cycle on the master's clock
  std::optional<std::uint64_t> system_time_ns;  ///< the same as DC system time; none: the line runs without clocks
  std::int64_t missed = 0;                      ///< periods of the line that were skipped since the task's last call
  /// Grid time since the task's last call; 0 at the first.
  std::chrono::nanoseconds elapsed{};
  std::span<const Axis> axes;  ///< of the line; Axis::inputs() in SI units. Empty: the line has no axes
  /// What the axes were commanded last, in SI units; before the motion that is of the cycle before.
  std::span<const trajectory::AxisSetpoint> setpoints;
  std::span<const std::byte> inputs;  ///< of the process image
  std::span<const bool> valid;   ///< by slave: its inputs are of the last exchange it was due in; else they are stale
  std::span<std::byte> outputs;  ///< of the process image; what axes are driven with is written by the motion
};

/// Work of the application in the cycle: a controller, logic between slaves, a measurement.
class CycleTask {
 public:
  virtual ~CycleTask() = default;
  /// In the cycle, on its thread: no exceptions, no memory, no locks, no waiting. \rtsafe
  virtual void update(const TaskCycle& cycle) noexcept = 0;

 protected:
  CycleTask() = default;
  /// A task is used where it is.
  CycleTask(const CycleTask&) = default;
  CycleTask& operator=(const CycleTask&) = default;
};

/// When a task runs.
struct TaskTiming {
  /// Its place within a cycle.
  enum class Order : std::uint8_t {
    kBeforeMotion,  ///< inputs are read; what it commands leaves with the next frame
    kAfterMotion,   ///< the setpoints of this cycle are known
  };
  std::uint32_t divider = 1;  ///< it runs in every n-th cycle, 1 at least
  std::uint32_t phase = 0;    ///< in those whose number has this remainder; below `divider`
  Order order = Order::kBeforeMotion;
};

/// What the runs of a task have cost since it was made. To be read when the cycle rests.
struct TaskFigures {
  std::uint64_t calls = 0;
  rt::Histogram cost;  ///< of one call
  /// Heap and lock functions that the task has called. Counted where the library was built with
  /// DRIVELINE_TASK_GUARD (the default in a debug build), else 0.
  std::uint64_t forbidden_calls = 0;
};

/// The tasks of a line, in the order in which they were added. One whose cycle was skipped runs in the next one.
class TaskSchedule {
 public:
  /// `task` must outlive the schedule. Before the cycle runs.
  /// @throws std::invalid_argument for a divider of 0 and a phase that is not below the divider.
  void add(CycleTask& task, TaskTiming timing);

  // The cycle's side. \rtsafe
  /// A cycle begins.
  void begin(const rt::CycleStart& start) noexcept;
  /// Runs the tasks of this place that are due. `now`: the cycle's part of what they are given. `period`: of the line.
  void run(TaskTiming::Order order, TaskCycle now, std::chrono::nanoseconds period, rt::Clock& clock) noexcept;

  /// In the order of add(). When the cycle rests.
  [[nodiscard]] const TaskFigures& figures(std::size_t task) const noexcept { return entries_[task]->figures; }
  /// \rtsafe
  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }

 private:
  struct Entry {
    CycleTask* task;
    TaskTiming timing;
    TaskFigures figures{};
    std::int64_t turn = 0;  ///< number of the last cycle of the task's own
    std::int64_t last = 0;  ///< cycle of the last call
    std::int64_t missed = 0;
    bool due = false;
  };

  std::vector<std::unique_ptr<Entry>> entries_;
};

}  // namespace driveline::ecat_master
