// What the axes of a run report, and the verdict on them.
#include "operation/line_run.hpp"

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "operation/axis_verdict.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

/// If a signal ends the run after this time, an axis that was never enabled is a fault.
constexpr auto kTimeToEnable = std::chrono::seconds{1};

}  // namespace

/// Reports requests to single axes and groups, and their results.
void LineRun::note_requests() {
  auto& axes = axis_requests();
  auto& groups = *motion_.settings().groups;
  axes.watch();
  groups.watch();
  for (auto& event : axes.take_events()) note(std::move(event), Severity::kNotice);
  for (auto& event : groups.take_events()) note(std::move(event), Severity::kNotice);
  for (auto& change : axes.authority().take_changes())
    authority_.add({seconds_in_operation(), config_.axes[change.axis].name, std::move(change)});
}

/// Reports the clients that stream setpoints, and the faults of their setpoints.
void LineRun::note_streams() {
  auto* stream = motion_.stream();
  if (!stream) return;
  for (auto& event : stream->poll()) note(std::move(event.facts), event.severity);
}

/// Stores the state of the groups before the axes come to rest at the end of the run.
void LineRun::note_groups() {
  for (std::size_t group = 0; group < config_.axis_groups.size(); ++group) {
    const auto status = motion_.settings().groups->status(group);
    AxisGroupRunReport report{config_.axis_groups[group].name, {}, {}, status.owner, {}, {}, {}};
    for (const auto& axis : status.limits.group.axes) report.axes.push_back(axis.name);
    report.machine = config_.axis_groups[group].machine;
    report.coordinates = status.limits.group.coordinates;
    report.place = status.place;
    if (status.report) report.state = to_text(status.report->state);
    groups_.push_back(std::move(report));
  }
}

/// Checks the axes at the end of a run without any other failure.
void LineRun::judge_axes() {
  if (!motion_.get() || had(Severity::kFailure) || operation_time_ == nanoseconds{0}) return;
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    const auto& axis = config_.axes[i];
    const auto& seen = samples_.recorder()->following_errors()[i];
    if (axis.is_virtual()) continue;
    // A run that is stopped right at its start does not wait for the axes.
    if (seen.samples == 0 && stop_requested() && operation_time_ < kTimeToEnable) continue;
    if (seen.samples == 0 && !motion_.get()->enables()) continue;
    const auto period = config_.period * exchange_divider(config_, config_.slaves[axis.slave]);
    if (auto verdict = axis_verdict(axis, seen, period)) fail_with(std::move(*verdict));
  }
}

}  // namespace driveline::runtime
