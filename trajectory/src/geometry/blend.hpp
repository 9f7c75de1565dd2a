#pragma once

#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// Junction of two pieces.
struct Joint {
  PathGeometry before;     ///< end of the first piece
  PathGeometry behind;     ///< start of the second piece
  double half_turn = 0.0;  ///< sine of half the angle between their directions
  bool is_smooth = false;  ///< neither direction nor curvature jumps
};

[[nodiscard]] Joint joint_of(const PathPiece& before, const PathPiece& behind) noexcept;

/// Replacement of a corner.
struct Blend {
  double cut = 0.0;               ///< length cut from the end of the first piece and from the start of the second one
  std::vector<PathPiece> pieces;  ///< pieces between the cuts, with continuous direction and curvature at both
};

/// Rounds the joint of two pieces with a deviation of at most `tolerance` (> 0), cutting at most `longest_cut` from
/// each.
[[nodiscard]] tl::expected<Blend, PathMoveError> blend(const PathPiece& before, const PathPiece& behind,
                                                       const Joint& joint, double tolerance, double longest_cut);

}  // namespace driveline::trajectory
