#include "operation/single_motion.hpp"

#include "driveline/runtime/event.hpp"

#include <algorithm>
#include <utility>

namespace driveline::runtime {

using motion::AxisCommand;
using motion::AxisRequest;
using motion::PlcopenState;

SingleMotion::SingleMotion(std::unique_ptr<motion::SingleAxes> axes, AxisRequests& axis_requests, bool enable)
    : axes_(std::move(axes)),
      axis_requests_(axis_requests),
      enable_(enable),
      failed_(axes_->axes().size()),
      warned_(axes_->gantries()) {}

SingleMotion::~SingleMotion() {
  if (group_requests_ != nullptr) group_requests_->close();
  axis_requests_.close();
}

void SingleMotion::add(std::unique_ptr<motion::AxisGroups> groups, std::vector<std::vector<GroupOutputLimits>> outputs,
                       GroupRequests& group_requests, bool thread) {
  groups_ = std::move(groups);
  group_outputs_ = std::move(outputs);
  group_requests_ = &group_requests;
  thread_ = thread;
  failed_groups_.resize(groups_->groups().size());
}

void SingleMotion::start() {
  axis_requests_.open(*axes_);
  if (groups_) {
    if (thread_) groups_->start_planning();
    group_requests_->open(*groups_, *axes_, group_outputs_);
  }
  if (!enable_) return;
  AxisCaller start;
  start.name = std::string(kStartOfRun);
  AxisRequest power;
  power.command = AxisCommand::kPower;
  for (std::size_t axis = 0; axis < failed_.size(); ++axis) {
    if (!goes_with_leader(axis)) static_cast<void>(axis_requests_.submit(start, axis, power));
  }
  axis_requests_.leave(start.name, false);
}

void SingleMotion::request_stop() {
  if (group_requests_ != nullptr) group_requests_->close();
  axis_requests_.close();
  AxisRequest power;
  power.command = AxisCommand::kPower;
  power.on = false;
  for (std::size_t axis = 0; axis < failed_.size(); ++axis) {
    if (!goes_with_leader(axis)) switch_off_.push_back(axes_->submit(axis, power));
  }
}

bool SingleMotion::goes_with_leader(std::size_t axis) const {
  const auto gantry = axes_->gantry_of(axis);
  return gantry && axes_->gantry_settings(*gantry).follower == axis;
}

/// Returns the skew of the gantry of an axis; none: the axis has no gantry.
std::optional<GantrySkew> SingleMotion::skew_of(std::size_t axis) const {
  const auto gantry = axes_->gantry_of(axis);
  if (!gantry) return std::nullopt;
  return GantrySkew{axes_->gantry_report(*gantry).stopped_at, axes_->gantry_settings(*gantry).skew_limit};
}

void SingleMotion::poll_gantries(const Tell& tell) {
  for (std::size_t gantry = 0; gantry < warned_.size(); ++gantry) {
    const auto report = axes_->gantry_report(gantry);
    const bool warns = report.warned;
    if (warns && warned_[gantry] == 0) {
      const auto& settings = axes_->gantry_settings(gantry);
      const auto& leader = axes_->axes()[settings.leader].config();
      tell(events::GantryAskew{events::event_axis(leader), axes_->axes()[settings.follower].config().name, report.skew,
                               settings.skew_warning, settings.skew_limit},
           Severity::kNotice);
    }
    warned_[gantry] = warns ? 1 : 0;
  }
}

bool SingleMotion::off() const {
  return std::all_of(switch_off_.begin(), switch_off_.end(),
                     [this](std::uint64_t request) { return axes_->report(request).over(); });
}

void SingleMotion::poll(const Tell& tell) {
  poll_groups(tell);
  poll_gantries(tell);
  for (std::size_t axis = 0; axis < failed_.size(); ++axis) {
    const auto report = axes_->axis_report(axis);
    const bool fails = report.state == PlcopenState::kErrorStop;
    if (fails == (failed_[axis] != 0)) continue;
    failed_[axis] = fails ? 1 : 0;
    const auto& config = axes_->axes()[axis].config();
    if (fails) {
      tell(events::AxisFailed{events::event_axis(config), report.error, report.error_code, skew_of(axis)},
           Severity::kFault);
    } else {
      tell(events::AxisRestored{config.name}, Severity::kNotice);
    }
  }
}

void SingleMotion::poll_groups(const Tell& tell) {
  if (!groups_) return;
  if (!thread_) groups_->plan();
  for (std::size_t group = 0; group < failed_groups_.size(); ++group) {
    const auto report = groups_->group_report(group);
    const bool fails = report.state == motion::GroupState::kErrorStop;
    if (fails == (failed_groups_[group] != 0)) continue;
    failed_groups_[group] = fails ? 1 : 0;
    if (fails) {
      tell(events::GroupFailed{group_requests_->event_group(group), group_requests_->refusal_of(report)},
           Severity::kFault);
    } else {
      tell(events::GroupRestored{groups_->groups()[group].name}, Severity::kNotice);
    }
  }
}

void SingleMotion::judge(const Tell& tell) const {
  for (std::size_t axis = 0; axis < failed_.size(); ++axis) {
    const auto report = axes_->axis_report(axis);
    if (report.state != PlcopenState::kErrorStop) continue;
    const auto& config = axes_->axes()[axis].config();
    tell(events::AxisNotReset{events::event_axis(config), report.error, report.error_code, skew_of(axis)},
         Severity::kFailure);
  }
}

}  // namespace driveline::runtime
