#pragma once

#include <memory>
#include <vector>

#include "driveline/runtime/setup/task.hpp"

namespace driveline::runtime {

/// The tasks of a line and the axes they drive.
class LineTasks {
 public:
  /// Errors (kCall): see Line::add().
  [[nodiscard]] Result<void> add(Task& task, TaskPlan plan, const LineConfig& config);
  /// Any axis is driven by a task.
  [[nodiscard]] bool drive() const noexcept;

  /// Makes what the axes follow; null when no task drives one.
  [[nodiscard]] ecat_master::SetpointSource* make_source(const LineConfig& config);
  /// Lets the tasks get ready; after make_source(). Error: that of the first one that cannot.
  [[nodiscard]] Result<void> prepare(const LineConfig& config, const ecat_master::ProcessVariables& process_data);
  /// Null: there are no tasks.
  [[nodiscard]] ecat_master::TaskSchedule* schedule() noexcept { return entries_.empty() ? nullptr : &schedule_; }
  /// In the order of add(). When the cycle rests.
  [[nodiscard]] std::vector<TaskReport> report() const;

 private:
  struct Entry {
    Task* task;
    TaskPlan plan;
    std::vector<TaskAxis> axes;
  };

  [[nodiscard]] const Entry* driver_of(std::size_t axis) const noexcept;

  std::vector<Entry> entries_;
  ecat_master::TaskSchedule schedule_;
  std::unique_ptr<ecat_master::DrivenAxes> driven_;
};

}  // namespace driveline::runtime
