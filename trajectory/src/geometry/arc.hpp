#pragma once

#include <cstddef>
#include <tl/expected.hpp>

#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// Computes the arc of a kArc move that starts at `from`.
[[nodiscard]] tl::expected<CircularArc, PathMoveError> arc_around(const GroupVector& from, const PathMove& move);
/// Computes the arc of a kArcVia move that starts at `from`.
[[nodiscard]] tl::expected<CircularArc, PathMoveError> arc_via(const GroupVector& from, const PathMove& move);

}  // namespace driveline::trajectory
