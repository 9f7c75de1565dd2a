#pragma once

#include "support/report.hpp"

namespace driveline::bench {

/// Measures the CANopen master with eight axes on virtual time, by turns with EtherCAT: its part of a cycle, port calls
/// apart, and the processor time of whole lines at 2 ms.
void measure_can_master(Report& report, int cycles);

}  // namespace driveline::bench
