#pragma once

#include <span>
#include <vector>

#include "driveline/trajectory/path.hpp"

/// The coefficients of all segments of a path, one after the other, as segment.hpp has them. They allocate and belong
/// to start-up.
namespace driveline::trajectory::segment_detail {

/// One column.
[[nodiscard]] std::vector<double> hold_segments(const Path& path);
/// Two columns.
[[nodiscard]] std::vector<double> linear_segments(const Path& path);
/// Two columns.
[[nodiscard]] std::vector<double> cosine_segments(const Path& path);
/// Four columns.
[[nodiscard]] std::vector<double> hermite_segments(const Path& path);
/// Six columns.
[[nodiscard]] std::vector<double> quintic_segments(const Path& path);
/// Four columns.
[[nodiscard]] std::vector<double> natural_segments(const Path& path);
/// Four columns. Throws as Interpolator::clamped_spline().
[[nodiscard]] std::vector<double> clamped_segments(const Path& path, std::span<const double> start_velocity,
                                                   std::span<const double> end_velocity);
/// Four columns.
[[nodiscard]] std::vector<double> b_spline_segments(const Path& path);

}  // namespace driveline::trajectory::segment_detail
