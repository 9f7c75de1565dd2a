#pragma once

#include <optional>
#include <vector>

#include "driveline/runtime/event/group_events.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::runtime {

/// A group of up to trajectory::kMaxGroupAxes axes, as the ways of its moves are checked.
struct WayLimits {
  events::EventGroup group;                                      ///< names and units
  std::vector<std::optional<trajectory::PositionRange>> ranges;  ///< of each axis, as requests count; none: no limits
};

/// Where a move ends, from there on the next one goes.
[[nodiscard]] const trajectory::GroupVector& end_of(const trajectory::PathMove& move);

/// What is wrong with a move, in absolute places, that begins at `from`: its shape, or that it leaves the software
/// limits; none: nothing.
[[nodiscard]] std::optional<GroupRefusal> check_way(const WayLimits& limits, const trajectory::GroupVector& from,
                                                    const trajectory::PathMove& move);

}  // namespace driveline::runtime
