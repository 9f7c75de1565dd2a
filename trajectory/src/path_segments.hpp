#pragma once

#include <span>
#include <vector>

#include "driveline/trajectory/path.hpp"

/// Functions that compute the coefficients of all segments of a path in sequence, in the layout of segment.hpp. They
/// allocate, so call them at start-up.
namespace driveline::trajectory::segment_detail {

/// One column per segment.
[[nodiscard]] std::vector<double> hold_segments(const Path& path);
/// Two columns per segment.
[[nodiscard]] std::vector<double> linear_segments(const Path& path);
/// Two columns per segment.
[[nodiscard]] std::vector<double> cosine_segments(const Path& path);
/// Four columns per segment.
[[nodiscard]] std::vector<double> hermite_segments(const Path& path);
/// Six columns per segment.
[[nodiscard]] std::vector<double> quintic_segments(const Path& path);
/// Four columns per segment.
[[nodiscard]] std::vector<double> natural_segments(const Path& path);
/// Four columns per segment. Throws like Interpolator::clamped_spline().
[[nodiscard]] std::vector<double> clamped_segments(const Path& path, std::span<const double> start_velocity,
                                                   std::span<const double> end_velocity);
/// Four columns per segment.
[[nodiscard]] std::vector<double> b_spline_segments(const Path& path);

}  // namespace driveline::trajectory::segment_detail
