// Motion of the axes of a run, and its events.
#include "operation/line_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "operation/axis_verdict.hpp"
#include "operation/joint_motion.hpp"
#include "operation/single_motion.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

/// If a signal ends the run after this time, an axis that was never enabled is a fault.
constexpr auto kTimeToEnable = std::chrono::seconds{1};

}  // namespace

Result<void> LineRun::check_stream() const {
  if (!config_.stream) return {};
  if (bus_.virtual_time()) {
    return fail(ErrorKind::kSetting, "needs real time: its clients cannot follow virtual time", "[stream]");
  }
  const auto owner = joint_owner();
  if (owner.empty()) return {};
  return fail(ErrorKind::kSetting,
              fmt::format("the {} of this run moves the axes together: no axis can be streamed to", owner), "[stream]");
}

/// Returns the name of what moves all axes together, with a firm lease; empty: nothing.
std::string_view LineRun::joint_owner() const noexcept {
  if (settings_.tasks->drive()) return "task";
  if (settings_.source != nullptr) return "program";
  return config_.path ? "path" : "";
}

/// An axis whose drive plans its motions cannot be moved together with others.
Result<void> LineRun::check_profile_axes() const {
  const auto& axes = config_.axes;
  const auto found =
      std::find_if(axes.begin(), axes.end(), [](const auto& axis) { return motion::cia402::by_drive(axis.mode); });
  const auto owner = joint_owner();
  if (owner.empty() || found == axes.end()) return {};
  return fail(ErrorKind::kSetting,
              fmt::format("the {} of this run gives setpoints to all axes, but the drive of \"{}\" plans its motions "
                          "itself (mode \"{}\"): it can be moved by requests to it alone",
                          owner, found->name, to_text(found->mode)));
}

/// Makes the motion; axes that are not moved together wait for individual requests.
Result<void> LineRun::make_motion() {
  if (!joint_owner().empty()) {
    motion_ = make_joint_motion();
    return {};
  }
  auto made = make_single_motion();
  if (!made) return tl::unexpected(made.error());
  motion_ = std::move(*made);
  return {};
}

Result<std::unique_ptr<LineMotion>> LineRun::make_single_motion() {
  auto axes = std::make_unique<motion::SingleAxes>(bus_.make_axes(), single_axis_settings(config_));
  for (const auto& gantry : config_.gantries) axes->add_gantry(gantry);
  if (config_.stream) {
    stream_ = std::make_unique<StreamService>(config_, *axes, settings_.axis_requests->authority());
    settings_.tasks->serve(stream_->task());
  }
  auto& single = *axes;
  auto motion = std::make_unique<SingleMotion>(std::move(axes), *settings_.axis_requests, settings_.enable);
  if (auto added = add_groups(*motion, single); !added) return tl::unexpected(added.error());
  if (auto added = add_couplings(single); !added) return tl::unexpected(added.error());
  return motion;
}

/// Call before add_couplings(): an axis of a group may be a master whose slave follows its setpoint of the same cycle.
Result<void> LineRun::add_groups(SingleMotion& motion, motion::SingleAxes& axes) {
  if (config_.axis_groups.empty()) return {};
  auto outputs = GroupOutputs::make(config_, bus_.process_data().variables, bus_.process_data().copies);
  if (!outputs) return tl::unexpected(outputs.error());
  group_outputs_ = std::move(*outputs);
  std::vector<motion::AxisGroupSettings> groups;
  std::vector<std::vector<GroupOutputLimits>> limits;
  for (std::size_t i = 0; i < config_.axis_groups.size(); ++i) {
    const auto& described = config_.axis_groups[i];
    auto& group = groups.emplace_back(motion::AxisGroupSettings{described.name, described.axes});
    if (described.machine) group.kinematics = &described.machine->kinematics();
    group.tool = described.tool;
    auto& values = limits.emplace_back();
    if (!group_outputs_[i]) continue;
    group.outputs = group_outputs_[i].get();
    values = group_outputs_[i]->limits();
    settings_.tasks->serve(*group_outputs_[i], {.order = motion::TaskTiming::Order::kAfterMotion});
  }
  try {
    motion.add(std::make_unique<motion::AxisGroups>(axes, std::move(groups), config_.period), std::move(limits),
               *settings_.groups, !bus_.virtual_time());
  } catch (const std::invalid_argument& wrong) {
    return fail(ErrorKind::kSetting, wrong.what(), "[[axis_group]]");
  }
  return {};
}

Result<void> LineRun::add_couplings(motion::SingleAxes& axes) {
  if (config_.couplings.couplings.empty()) return {};
  auto couplings = LineCouplings::make(config_, axes, bus_.process_data().variables,
                                       [this](std::size_t slave) { return bus_.input_age(slave); });
  if (!couplings) return tl::unexpected(couplings.error());
  couplings_ = std::move(*couplings);
  settings_.axis_requests->attach(*couplings_);
  return {};
}

std::unique_ptr<LineMotion> LineRun::make_joint_motion() {
  auto axes = bus_.make_axes();
  const auto settings = motion_settings(config_);
  auto motion = settings_.source != nullptr
                    ? std::make_unique<motion::Motion>(std::move(axes), *settings_.source, settings)
                    : std::make_unique<motion::Motion>(std::move(axes), *settings_.path, settings);
  return std::make_unique<JointMotion>(std::move(motion), config_, *settings_.axis_requests,
                                       std::string(joint_owner()));
}

/// Reports requests to single axes and groups, and their results.
void LineRun::note_requests() {
  settings_.axis_requests->watch();
  settings_.groups->watch();
  for (auto& event : settings_.axis_requests->take_events()) note(std::move(event), Severity::kNotice);
  for (auto& event : settings_.groups->take_events()) note(std::move(event), Severity::kNotice);
  for (auto& change : settings_.axis_requests->authority().take_changes())
    authority_.add({seconds_in_operation(), config_.axes[change.axis].name, std::move(change)});
}

/// Reports the clients that stream setpoints, and the faults of their setpoints.
void LineRun::note_streams() {
  if (!stream_) return;
  for (auto& event : stream_->poll()) note(std::move(event.facts), event.severity);
}

/// Stores the state of the groups before the axes come to rest at the end of the run.
void LineRun::note_groups() {
  for (std::size_t group = 0; group < config_.axis_groups.size(); ++group) {
    const auto status = settings_.groups->status(group);
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
  if (!motion_ || had(Severity::kFailure) || operation_time_ == nanoseconds{0}) return;
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    const auto& axis = config_.axes[i];
    const auto& seen = recorder_->following_errors()[i];
    if (axis.is_virtual()) continue;
    // A run that is stopped right at its start does not wait for the axes.
    if (seen.samples == 0 && stop_requested() && operation_time_ < kTimeToEnable) continue;
    if (seen.samples == 0 && !motion_->enables()) continue;
    const auto period = config_.period * exchange_divider(config_, config_.slaves[axis.slave]);
    if (auto verdict = axis_verdict(axis, seen, period)) fail_with(std::move(*verdict));
  }
}

}  // namespace driveline::runtime
