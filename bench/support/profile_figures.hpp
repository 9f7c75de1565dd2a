#pragma once

#include <cstddef>

#include "support/report.hpp"

namespace driveline::bench {

/// How long planning a time-optimal profile takes: one axis, and 3 and 7 that end together, over seeded random
/// problems. Every profile is checked outside of what is timed. Returns how many problems had no profile, or a wrong
/// one.
[[nodiscard]] std::size_t add_profile_figures(Report& report, const Options& options);

}  // namespace driveline::bench
