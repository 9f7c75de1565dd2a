#pragma once

#include <memory>
#include <string>

#include "driveline/motion/cycle/cycle_trace.hpp"
#include "driveline/rt/switch_log.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/record/run_report.hpp"

namespace driveline::runtime {

/// Trace of the slowest cycles of a run, with the threads that displaced the cycle where the machine records them.
class RunTrace {
 public:
  /// Makes the trace. Call before the cycle starts.
  void open(const LineConfig& config, bool virtual_time);
  /// Returns the trace for the cycle; null before open().
  [[nodiscard]] motion::CycleTrace* cycles() noexcept { return trace_.get(); }
  /// Sets the traced cycles in the report. Call after the cycle has ended.
  void report(RunReport& report) const;

 private:
  std::unique_ptr<rt::SwitchLog> switches_;  ///< switches of the CPU of the cycle; null: not recorded
  std::string switches_unknown_;             ///< why `switches_` is null
  std::unique_ptr<motion::CycleTrace> trace_;
};

}  // namespace driveline::runtime
