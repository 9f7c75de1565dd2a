#pragma once

#include <string>

namespace driveline::bench {

/// Writes the curves that docs/figures/make.sh draws, one CSV file each, into `folder` (which exists): how the cycle
/// locks in, how far SYNC0 of every slave is from the reference's when all goes well, with jitter and with loss, when
/// the reference clock is lost, and in a ring that breaks. All by true time. Throws on failure.
void write_clock_figures(const std::string& folder);

}  // namespace driveline::bench
