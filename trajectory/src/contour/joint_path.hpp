#pragma once

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// Converts a path point from the coordinates of the moves to the space of the axes. Writes nothing if the machine
/// cannot be there. \rtsafe
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

/// Bounds of the derivatives on a stretch of a piece.
struct StretchBounds {
  PathBounds axes;         ///< bounds per axis
  double curvature = 0.0;  ///< curvature of the tool path, 1/m
  double third = 0.0;      ///< norm of the third derivative of the tool path, 1/m²
  /// The values between the samples may be considerably larger; shorter stretches would give better bounds.
  bool is_coarse = false;
};

/// Computes the bounds of a stretch of a piece that PathCheck has accepted. \rtsafe
[[nodiscard]] StretchBounds stretch_bounds(const ContourSettings& settings, const PathPiece& piece, double begin,
                                           double end) noexcept;

}  // namespace driveline::trajectory
