#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/canopen_port/can_port.hpp"

namespace driveline::runtime {

/// Figures of the CAN bus of a run.
struct CanReport {
  std::uint32_t bit_rate = 0;      ///< bit/s
  double planned_load = 0.0;       ///< share of a SYNC period that SYNC and its PDOs take, without stuff bits
  double worst_load = 0.0;         ///< the same in the worst case of stuff bits
  canopen::PortStatistics port;    ///< frames and error counters of the adapter since it was opened
  std::uint64_t lost_pdos = 0;     ///< TPDOs that were due and did not come
  std::uint64_t late_pdos = 0;     ///< TPDOs that came after the next SYNC, or twice
  std::uint64_t unsent_pdos = 0;   ///< RPDOs with SYNC that the adapter did not take
  std::uint64_t unsent_syncs = 0;  ///< SYNCs that the adapter did not take
  std::uint64_t emergencies = 0;   ///< EMCY messages of all nodes, without those that tell the end of an error
};

/// Share of the bus that carried frames, measured in every cycle in operation.
struct BusLoad {
  double mean = 0.0;          ///< 0 to 1
  double maximum = 0.0;       ///< load of the busiest cycle
  std::uint64_t samples = 0;  ///< cycles; 0: the bus does not measure it
};

}  // namespace driveline::runtime
