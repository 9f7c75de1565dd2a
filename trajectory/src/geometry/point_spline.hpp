#pragma once

#include <span>
#include <vector>

#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// The natural cubic spline through at least two points, each different from the previous one, parametrised by chord
/// length: one polynomial, with a parameter from 0 to 1, per chord.
[[nodiscard]] std::vector<PathPolynomial> point_spline(std::span<const GroupVector> points);

}  // namespace driveline::trajectory
