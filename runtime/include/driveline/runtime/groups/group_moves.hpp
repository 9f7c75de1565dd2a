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

/// Limits of an output that moves of a group change.
struct GroupOutputLimits {
  std::string name;    ///< name in moves
  double least = 0.0;  ///< lowest permitted whole number
  double most = 1.0;   ///< highest permitted whole number
};

/// Limits of a group of up to trajectory::kMaxGroupAxes axes for the check of its moves.
struct MoveLimits {
  events::EventGroup group;  ///< names and units
  /// Range of each axis, as requests count; none: no limits.
  std::vector<std::optional<trajectory::PositionRange>> ranges;
  std::shared_ptr<const trajectory::Machine> machine{};  ///< null: moves are given in axis positions
  std::vector<GroupOutputLimits> outputs{};              ///< moves name them by their index here
};

/// Returns the settings for checks of a machine: its kinematics, and the ranges of its joints. `limits.machine` must
/// outlive the result.
[[nodiscard]] trajectory::ContourSettings joint_settings(const MoveLimits& limits);
/// Returns the axes as sentences name them.
[[nodiscard]] std::vector<trajectory::NamedAxis> named_axes(const events::EventGroup& group);
/// Checks the outputs of a move; none: nothing is wrong.
[[nodiscard]] std::optional<GroupRefusal> check_outputs(const MoveLimits& limits, const trajectory::PathMove& move);

/// Returns the end of a move, at which the next one starts.
[[nodiscard]] const trajectory::GroupVector& end_of(const trajectory::PathMove& move);

/// Checks a move in absolute positions that starts at `from`: its shape, the software limits, whether the machine can
/// reach it, and its outputs. None: nothing is wrong.
[[nodiscard]] std::optional<GroupRefusal> check_group_move(const MoveLimits& limits,
                                                           const trajectory::GroupVector& from,
                                                           const trajectory::PathMove& move);

}  // namespace driveline::runtime
