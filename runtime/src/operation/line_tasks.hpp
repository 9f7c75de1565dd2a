#pragma once

#include <memory>
#include <vector>

#include "driveline/runtime/setup/task.hpp"

namespace driveline::runtime {

/// The tasks of a line, and the axes that they drive.
class LineTasks {
 public:
  /// Errors (kCall): see Line::add().
  [[nodiscard]] Result<void> add(Task& task, TaskPlan plan, const LineConfig& config);
  /// Whether a task drives any axis.
  [[nodiscard]] bool drive() const noexcept;

  /// Makes the source of the driven axes; null if no task drives one.
  [[nodiscard]] motion::SetpointSource* make_source(const LineConfig& config);
  /// Prepares the tasks; call after make_source(). Error: that of the first task that fails.
  [[nodiscard]] Result<void> prepare(const LineConfig& config, const ProcessVariables& process_data);
  /// Runs a task of the line itself, after those of the application. It is not reported. Call after all add().
  void serve(motion::CycleTask& task, motion::TaskTiming timing = {}) { schedule_.add(task, timing); }
  /// Returns the schedule; null: there are no tasks.
  [[nodiscard]] motion::TaskSchedule* schedule() noexcept { return schedule_.size() == 0 ? nullptr : &schedule_; }
  /// Returns the reports in the order of add(). Call while the cycle is idle.
  [[nodiscard]] std::vector<TaskReport> report() const;

 private:
  struct Entry {
    Task* task;
    TaskPlan plan;
    std::vector<TaskAxis> axes;
  };

  [[nodiscard]] const Entry* driver_of(std::size_t axis) const noexcept;

  std::vector<Entry> entries_;
  motion::TaskSchedule schedule_;
  std::unique_ptr<motion::DrivenAxes> driven_;
};

}  // namespace driveline::runtime
