#pragma once

#include "support/report.hpp"

namespace driveline::bench {

/// Measures when SYNC leaves on the real clock, with a master of eight axes on its real-time thread, against a bare
/// loop that sleeps and sends on the same port, in pairs of this duration by turns. The port is a socket that carries
/// frames as that of a CAN interface does; a thread at its other end answers each SYNC with the TPDOs of eight drives.
void measure_sync(Report& report, int pairs, double seconds);

}  // namespace driveline::bench
