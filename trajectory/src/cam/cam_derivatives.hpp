#pragma once

#include <span>

#include "driveline/trajectory/cam.hpp"

namespace driveline::trajectory {

/// Gives points slopes, and curvatures, of the parabolas through three neighbours. At the ends of a one-shot cam they
/// are zero; others know their neighbours across the end.
void estimate_slopes(std::span<CamPoint> points, CamKind kind);
void estimate_curvatures(std::span<CamPoint> points, CamKind kind);

/// Gives points the slopes of the cubic spline through them, whose curvature does not jump: with slope zero at the ends
/// of a one-shot cam, with the same slope and curvature at both ends of the others.
void spline_slopes(std::span<CamPoint> points, CamKind kind);

}  // namespace driveline::trajectory
