#pragma once

#include <span>

#include "driveline/trajectory/cam.hpp"

namespace driveline::trajectory {

/// Estimates the slopes, or curvatures, of all points from parabolas through three neighbours. At the ends of a
/// one-shot cam they are zero; for other cams the neighbours continue across the end.
void estimate_slopes(std::span<CamPoint> points, CamKind kind);
void estimate_curvatures(std::span<CamPoint> points, CamKind kind);

/// Computes the slopes of the cubic spline through the points, which has a continuous curvature: with slope zero at the
/// ends of a one-shot cam, with equal slope and curvature at both ends otherwise.
void spline_slopes(std::span<CamPoint> points, CamKind kind);

}  // namespace driveline::trajectory
