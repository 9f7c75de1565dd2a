#pragma once

#include <cstddef>

#include "support/report.hpp"

namespace driveline::bench {

/// Reports how long planning a time-optimal profile takes: for one axis, and for 3 and 7 that end together, over seeded
/// random problems. Every profile is checked outside the timed part. Returns the number of problems with no profile or
/// a wrong one.
[[nodiscard]] std::size_t add_profile_figures(Report& report, const Options& options);

}  // namespace driveline::bench
