#include "operation/run_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "driveline/runtime/setup/composition.hpp"
#include "operation/joint_motion.hpp"
#include "operation/single_motion.hpp"

namespace driveline::runtime {

RunMotion::RunMotion(LineBus& bus, Settings settings)
    : bus_(bus), config_(bus.config()), settings_(std::move(settings)) {}

RunMotion::~RunMotion() = default;

Result<void> RunMotion::check() const {
  if (auto possible = check_stream(); !possible) return possible;
  return check_profile_axes();
}

Result<void> RunMotion::check_stream() const {
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
std::string_view RunMotion::joint_owner() const noexcept {
  if (settings_.tasks->drive()) return "task";
  if (settings_.source != nullptr) return "program";
  return config_.path ? "path" : "";
}

/// An axis whose drive plans its motions cannot be moved together with others.
Result<void> RunMotion::check_profile_axes() const {
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

Result<void> RunMotion::make() {
  if (auto* driven = settings_.tasks->make_source(config_)) settings_.source = driven;
  if (settings_.path && !joint_owner().empty()) {
    motion_ = make_joint();
  } else if (settings_.path) {
    auto made = make_single();
    if (!made) return tl::unexpected(made.error());
    motion_ = std::move(*made);
  }
  return settings_.tasks->prepare(config_, bus_.process_data().variables);
}

Result<std::unique_ptr<LineMotion>> RunMotion::make_single() {
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
Result<void> RunMotion::add_groups(SingleMotion& motion, motion::SingleAxes& axes) {
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

Result<void> RunMotion::add_couplings(motion::SingleAxes& axes) {
  if (config_.couplings.couplings.empty()) return {};
  auto couplings = LineCouplings::make(config_, axes, bus_.process_data().variables,
                                       [this](std::size_t slave) { return bus_.input_age(slave); });
  if (!couplings) return tl::unexpected(couplings.error());
  couplings_ = std::move(*couplings);
  settings_.axis_requests->attach(*couplings_);
  return {};
}

std::unique_ptr<LineMotion> RunMotion::make_joint() {
  auto axes = bus_.make_axes();
  const auto settings = motion_settings(config_);
  auto motion = settings_.source != nullptr
                    ? std::make_unique<motion::Motion>(std::move(axes), *settings_.source, settings)
                    : std::make_unique<motion::Motion>(std::move(axes), *settings_.path, settings);
  return std::make_unique<JointMotion>(std::move(motion), config_, *settings_.axis_requests,
                                       std::string(joint_owner()));
}

}  // namespace driveline::runtime
