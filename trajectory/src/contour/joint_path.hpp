#pragma once

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// A point of the path in the space of the axes, from the same in the coordinates of the moves. Nothing is written when
/// the machine cannot be there. \rtsafe
inline PoseFault to_joints(const ContourSettings& settings, const PathGeometry& tool, PathGeometry& joints) noexcept {
  if (settings.kinematics == nullptr) {
    joints = tool;
    return {};
  }
  PathGeometry found = tool;
  const auto fault = settings.kinematics->inverse(tool, found);
  if (fault.kind != PoseFault::Kind::kUnreachable) joints = found;
  return fault;
}

/// Bounds of what a path asks for on a stretch of a piece.
struct StretchBounds {
  PathBounds axes;         ///< of each axis
  double curvature = 0.0;  ///< of the tool, 1/m
  double third = 0.0;      ///< length of the third derivative of the tool, 1/m²
  /// What lies between the samples may be more than a little: shorter stretches would show.
  bool is_coarse = false;
};

/// Of a stretch of a piece that PathCheck has found nothing wrong with. \rtsafe
[[nodiscard]] StretchBounds stretch_bounds(const ContourSettings& settings, const PathPiece& piece, double begin,
                                           double end) noexcept;

}  // namespace driveline::trajectory
