#include "operation/run_trace.hpp"

#include <utility>

namespace driveline::runtime {

void RunTrace::open(const LineConfig& config, bool virtual_time) {
  trace_ = std::make_unique<motion::CycleTrace>();
  if (virtual_time) return;
  if (!config.realtime.cpu) {
    switches_unknown_ =
        "threads that displaced the cycle are not recorded: the cycle has no CPU of its own ([realtime] cpu)";
    return;
  }
  auto switches = rt::SwitchLog::open(*config.realtime.cpu);
  if (!switches) {
    switches_unknown_ = switches.error().message();
    return;
  }
  switches_ = std::move(*switches);
  trace_->watch(*switches_);
}

void RunTrace::report(RunReport& report) const {
  if (trace_) report.trace = trace_->cycles();
  report.trace_without_switches = switches_unknown_;
}

}  // namespace driveline::runtime
