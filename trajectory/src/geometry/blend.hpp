#pragma once

#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// How two pieces meet.
struct Joint {
  PathGeometry before;     ///< where the first one ends
  PathGeometry behind;     ///< where the second one begins
  double half_turn = 0.0;  ///< sine of half the angle between their directions
  bool is_smooth = false;  ///< neither direction nor curvature jump
};

[[nodiscard]] Joint joint_of(const PathPiece& before, const PathPiece& behind) noexcept;

/// What takes the place of a corner.
struct Blend {
  double cut = 0.0;               ///< so much is cut from the end of the one piece and from the begin of the other
  std::vector<PathPiece> pieces;  ///< from cut to cut, with equal direction and curvature at both
};

/// Rounds the joint of two pieces without leaving them by more than `tolerance` (> 0), with no more than `longest_cut`
/// of either.
[[nodiscard]] tl::expected<Blend, PathMoveError> blend(const PathPiece& before, const PathPiece& behind,
                                                       const Joint& joint, double tolerance, double longest_cut);

}  // namespace driveline::trajectory
