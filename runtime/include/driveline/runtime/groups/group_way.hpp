#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/event/group_events.hpp"
#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/machine.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::runtime {

/// An output that moves of a group change.
struct GroupOutputLimits {
  std::string name;    ///< as moves call it
  double least = 0.0;  ///< of the whole numbers that it takes
  double most = 1.0;   ///< likewise
};

/// A group of up to trajectory::kMaxGroupAxes axes, as the ways of its moves are checked.
struct WayLimits {
  events::EventGroup group;                                      ///< names and units
  std::vector<std::optional<trajectory::PositionRange>> ranges;  ///< of each axis, as requests count; none: no limits
  std::shared_ptr<const trajectory::Machine> machine{};          ///< null: moves are in the positions of the axes
  std::vector<GroupOutputLimits> outputs{};                      ///< moves name them by their places here
};

/// What a machine is to be checked with: its kinematics, and the ranges of its joints. `limits.machine` must outlive
/// it.
[[nodiscard]] trajectory::ContourSettings joint_settings(const WayLimits& limits);
/// The axes by which sentences name them.
[[nodiscard]] std::vector<trajectory::NamedAxis> named_axes(const events::EventGroup& group);
/// What is wrong with the outputs of a move; none: nothing.
[[nodiscard]] std::optional<GroupRefusal> check_outputs(const WayLimits& limits, const trajectory::PathMove& move);

/// Where a move ends, from there on the next one goes.
[[nodiscard]] const trajectory::GroupVector& end_of(const trajectory::PathMove& move);

/// What is wrong with a move, in absolute places, that begins at `from`: its shape, that it leaves the software limits,
/// that the machine cannot be there, or its outputs; none: nothing.
[[nodiscard]] std::optional<GroupRefusal> check_way(const WayLimits& limits, const trajectory::GroupVector& from,
                                                    const trajectory::PathMove& move);

}  // namespace driveline::runtime
