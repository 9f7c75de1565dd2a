#pragma once

#include <array>
#include <cstddef>

namespace driveline::trajectory {

/// Maximum number of axes that move together along one geometric path.
inline constexpr std::size_t kMaxGroupAxes = 8;

/// One value per axis of a group, in rad or m by the kind of the axis (or a derivative of these). Unused axes are zero,
/// so that functions need not know the number of axes.
using GroupVector = std::array<double, kMaxGroupAxes>;

}  // namespace driveline::trajectory
