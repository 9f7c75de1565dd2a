#pragma once

#include "support/options.hpp"
#include "support/report.hpp"

namespace driveline::bench {

/// Adds what every interpolation method costs per axis and cycle of 125 us at 1, 8, 32 and 128 axes: of a path at 1 kHz
/// (path_METHOD), and of a stream at 1 kHz with its checks and limits (stream_METHOD, setpoints pushed included).
/// Against a bare loop that evaluates position, velocity and acceleration of as many cubics with coefficients in the
/// same order, and nothing else. Aims at 32 axes: 3 ns for the cubics, 6 ns for other methods of a path. Seeded: the
/// same setpoints each time.
void add_interpolation_figures(Report& report, const Options& options);

}  // namespace driveline::bench
