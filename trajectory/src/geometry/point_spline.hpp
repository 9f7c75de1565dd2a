#pragma once

#include <span>
#include <vector>

#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// The natural cubic spline through at least two points, all different from the one before, by the length of the
/// chords: one polynomial, of a parameter from 0 to 1, per chord.
[[nodiscard]] std::vector<PathPolynomial> point_spline(std::span<const GroupVector> points);

}  // namespace driveline::trajectory
