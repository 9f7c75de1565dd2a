#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/motion/path/driven_axes.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// The process data of a line by name.
using ProcessVariables = ecat_master::ProcessVariables;

/// An axis that a task drives.
struct TaskAxis {
  std::size_t number = 0;               ///< index in TaskCycle::axes and in the line description
  motion::DrivenAxis* drive = nullptr;  ///< commands the axis; lives as long as the line runs
};

/// Input for the preparation of a task; the task may store the references.
struct TaskSetup {
  const LineConfig& config;              ///< lives as long as the line
  const ProcessVariables& process_data;  ///< handles by name: process_data.entry<bool>("io.Input 1")
  std::span<const TaskAxis> axes;        ///< the axes of TaskPlan::drives, in that order
};

/// A task of the application in the cycle of a Line.
class Task : public motion::CycleTask {
 public:
  /// Called when the line is configured and the cycle is about to start, on the thread that runs the line. An error
  /// ends the run before anything has moved.
  [[nodiscard]] virtual Result<void> prepare(const TaskSetup& setup) {
    static_cast<void>(setup);
    return {};
  }
};

/// Settings of a task.
struct TaskPlan {
  std::string name;                   ///< name in the report; unique on the line, not empty
  motion::TaskTiming timing{};        ///< cycles in which it runs, and when in the cycle
  std::vector<std::string> drives{};  ///< names of the axes that it commands instead of a path
};

/// Run times of a task, in the report of a run.
struct TaskReport {
  std::string name;
  motion::TaskTiming timing;
  motion::TaskFigures figures;
};

}  // namespace driveline::runtime
