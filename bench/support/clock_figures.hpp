#pragma once

#include <string>

namespace driveline::bench {

/// Writes the curves that docs/figures/make.sh draws, one CSV file each, into `folder` (which must exist): the lock-in
/// of the cycle, the distance of every slave's SYNC0 from that of the reference without disturbances, with jitter and
/// with loss, after the loss of the reference clock, and in a ring that breaks. All in true time. Throws on failure.
void write_clock_figures(const std::string& folder);

}  // namespace driveline::bench
