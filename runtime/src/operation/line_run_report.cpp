// Report of a run after its end.
#include "operation/line_run.hpp"

#include <fmt/format.h>

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {
/// Call after the cycle has ended.
void LineRun::finish_fault_records() {
  for (auto& recorded : fault_records_->finish()) progress(std::move(recorded));
  if (fault_records_->problem()) fail_with(events::FileNotWritten{*fault_records_->problem()});
}

RunReport LineRun::make_report() {
  RunReport report;
  report.line = config_.name;
  report.state = state_;
  report.increments = config_.output.increments;
  report.period = config_.period;
  report.duration_s = seconds_in_operation();
  bus_.report(report);
  report.bus_load = samples_.recorder()->bus_load();
  trace_.report(report);
  if (auto* motion = motion_.get()) report.path_late = motion->control().path_late();
  report.longest_absence_at_s =
      std::chrono::duration<double>(report.statistics.longest_absence_at - operation_start_).count();
  report_axes(report);
  report.axis_groups = groups_;
  report.tasks = motion_.settings().tasks->report();
  if (const auto* telemetry = telemetry_.service()) report.telemetry = telemetry->report();
  report.events = events_.all();
  report.events_left_out = events_.left_out();
  report.authority = authority_.all();
  report_files(report);
  return report;
}

void LineRun::report_axes(RunReport& report) const {
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    const auto& axis = config_.axes[i];
    const auto& error = samples_.recorder()->following_errors()[i];
    const auto& unit = motion::position_unit(axis);
    const auto slave = axis.is_virtual() ? std::nullopt : std::optional(axis.slave);
    report.axes.push_back({axis.name, slave, error.maximum * axis.increments_per_unit,
                           error.rms() * axis.increments_per_unit, std::string(unit.name),
                           axis.increments_per_unit * unit.to_si(1.0), error.unavailable});
    report.axes.back().path_error = {error.path.maximum * axis.increments_per_unit,
                                     error.path.rms() * axis.increments_per_unit};
    report.axes.back().owner = axis_requests().authority().owner_of(i);
    report.axes.back().demand_recorded = error.demand;
    if (error.drive.samples == 0) continue;
    report.axes.back().by_drive = {error.drive.maximum * axis.increments_per_unit,
                                   error.drive.rms() * axis.increments_per_unit};
  }
}

void LineRun::report_files(RunReport& report) const {
  if (samples_.recorder()->rows() > 0 && !samples_.recorder()->problem())
    report.files["axes_csv"] = config_.output.directory / "axes.csv";
  const auto& records = fault_records_->files();
  for (std::size_t i = 0; i < records.size(); ++i) {
    report.files[i == 0 ? "flight_recorder_csv" : fmt::format("flight_recorder_{}_csv", i + 1)] = records[i];
  }
}

}  // namespace driveline::runtime
