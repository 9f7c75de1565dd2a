// Report of a run after its end.
#include "operation/line_run.hpp"

#include <fmt/format.h>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

}  // namespace

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
  for (const auto& wire : session_.wires()) {
    report.interfaces.push_back({wire.interface, wire.access_method, wire.steps_down});
  }
  report.duration_s = seconds_in_operation();
  report.statistics = master_.core()->statistics();
  if (const auto* runner = master_.runner()) {
    report.thread = runner->usage();
    report.wake_ahead = runner->wake_ahead().value_or(nanoseconds{0});
  }
  if (trace_) report.trace = trace_->cycles();
  report.trace_without_switches = switches_unknown_;
  if (motion_) report.path_late = motion_->control().path_late();
  report.longest_absence_at_s =
      std::chrono::duration<double>(report.statistics.longest_absence_at - operation_start_).count();
  report.round_trip_modelled = !config_.interface.has_value();
  report.process_data = view_image(config_, master_, master_.core()->groups(), &exchange_group_watch_);
  if (auto* watch = master_.clock_watch()) {
    const auto& follower = *master_.clock_follower();
    auto& clocks = report.clocks.emplace();
    clocks.locked = master_.clock_follower()->status().locked;
    clocks.differences = watch->all_differences();
    clocks.phase_errors = follower.phase_errors();
    for (const auto& margin : margins_) {
      clocks.margins.push_back({config_.slaves[margin.slave].name, margin.report});
    }
  }
  if (const auto* ring = session_.ring()) {
    report.ring = {ring->status(), ring->merged(), ring->halves(), ring->late_halves()};
  }
  report_axes(report);
  report.axis_groups = groups_;
  if (config_.axes.empty() && variables_) report.inputs = read_inputs(*variables_, master_.core()->image().inputs());
  report.tasks = settings_.tasks->report();
  report.eoe = services_.eoe();
  report.gateway_clients = services_.clients();
  if (telemetry_) report.telemetry = telemetry_->report();
  report.events = events_.all();
  report.events_left_out = events_.left_out();
  report.authority = authority_.all();
  if (watch_) report.recoveries = watch_->supervisor().recoveries();
  report_files(report);
  return report;
}

void LineRun::report_axes(RunReport& report) const {
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    const auto& axis = config_.axes[i];
    const auto& error = recorder_->following_errors()[i];
    const auto& unit = motion::position_unit(axis);
    const auto slave = axis.is_virtual() ? std::nullopt : std::optional(axis.slave);
    report.axes.push_back({axis.name, slave, error.maximum * axis.increments_per_unit,
                           error.rms() * axis.increments_per_unit, std::string(unit.name),
                           axis.increments_per_unit * unit.to_si(1.0), error.unavailable});
    report.axes.back().path_error = {error.path.maximum * axis.increments_per_unit,
                                     error.path.rms() * axis.increments_per_unit};
    report.axes.back().owner = settings_.axis_requests->authority().owner_of(i);
    report.axes.back().demand_recorded = error.demand;
    if (error.drive.samples == 0) continue;
    report.axes.back().by_drive = {error.drive.maximum * axis.increments_per_unit,
                                   error.drive.rms() * axis.increments_per_unit};
  }
}

void LineRun::report_files(RunReport& report) const {
  if (recorder_->rows() > 0 && !recorder_->problem()) report.files["axes_csv"] = config_.output.directory / "axes.csv";
  const auto& records = fault_records_->files();
  for (std::size_t i = 0; i < records.size(); ++i) {
    report.files[i == 0 ? "flight_recorder_csv" : fmt::format("flight_recorder_{}_csv", i + 1)] = records[i];
  }
}

}  // namespace driveline::runtime
