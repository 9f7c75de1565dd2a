#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/ecat_master/cyclic/cycle_task.hpp"
#include "driveline/ecat_master/cyclic/driven_axes.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// An axis that a task drives.
struct TaskAxis {
  std::size_t number = 0;                    ///< in TaskCycle::axes, and in the line description
  ecat_master::DrivenAxis* drive = nullptr;  ///< what commands it; lives as long as the line runs
};

/// What a task may look at and keep before the cycle begins.
struct TaskSetup {
  const LineConfig& config;                           ///< lives as long as the line
  const ecat_master::ProcessVariables& process_data;  ///< handles by name: process_data.entry<bool>("io.Input 1")
  std::span<const TaskAxis> axes;                     ///< those of TaskPlan::drives, in that order
};

/// Work of the application in the cycle of a Line.
class Task : public ecat_master::CycleTask {
 public:
  /// The line is configured, and the cycle is about to begin. On the thread that runs the line. An error ends the run
  /// before anything has moved.
  [[nodiscard]] virtual Result<void> prepare(const TaskSetup& setup) {
    static_cast<void>(setup);
    return {};
  }
};

/// How a task is run.
struct TaskPlan {
  std::string name;                   ///< in the report; unique on the line, not empty
  ecat_master::TaskTiming timing{};   ///< in which cycles, and where in them
  std::vector<std::string> drives{};  ///< names of the axes that it commands; they follow no path then
};

/// What a task has cost, in the report of a run.
struct TaskReport {
  std::string name;
  ecat_master::TaskTiming timing;
  ecat_master::TaskFigures figures;
};

}  // namespace driveline::runtime
