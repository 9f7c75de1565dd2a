#pragma once

#include <array>
#include <cstddef>

namespace driveline::trajectory {

/// The most axes that move together along one geometric path.
inline constexpr std::size_t kMaxGroupAxes = 8;

/// A value for each axis of a group, in rad or m by the kind of the axis (or a derivative of that). Axes that the group
/// does not have are zero, so that nothing needs to know how many there are.
using GroupVector = std::array<double, kMaxGroupAxes>;

}  // namespace driveline::trajectory
