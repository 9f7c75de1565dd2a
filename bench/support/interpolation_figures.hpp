#pragma once

#include "support/options.hpp"
#include "support/report.hpp"

namespace driveline::bench {

/// Reports the cost of every interpolation method per axis and cycle of 125 us at 1, 8, 32 and 128 axes: of a path at 1
/// kHz (path_METHOD), of the curve of a stream at 1 kHz (curve_METHOD), and of the whole stream with its checks and
/// limits (stream_METHOD, including pushed setpoints). The baseline is a bare loop that only evaluates position,
/// velocity and acceleration of as many cubics with coefficients in the same order. Aims at 32 axes: 3 ns for cubics, 6
/// ns for other methods. Seeded: the setpoints are the same each time.
void add_interpolation_figures(Report& report, const Options& options);

}  // namespace driveline::bench
