#pragma once

#include <cstddef>
#include <tl/expected.hpp>

#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// The arc of a move of kind kArc that begins at `from`.
[[nodiscard]] tl::expected<CircularArc, PathMoveError> arc_around(const GroupVector& from, const PathMove& move);
/// The arc of a move of kind kArcVia that begins at `from`.
[[nodiscard]] tl::expected<CircularArc, PathMoveError> arc_via(const GroupVector& from, const PathMove& move);

}  // namespace driveline::trajectory
