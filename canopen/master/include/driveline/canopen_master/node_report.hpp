#pragma once

#include <cstdint>

namespace driveline::canopen {

/// What the cycle knows of a node. Plain value.
struct NodeReport {
  bool valid = false;              ///< its outputs of the last period were sent, and every answer to the last SYNC came
  bool operational = false;        ///< CanCycle::set_operational(), as the cycle has taken it over
  bool heard = false;              ///< every one of its TPDOs has come at least once since it was last not operational
  std::uint32_t stale_cycles = 0;  ///< cycles since it was last valid
  std::uint64_t lost = 0;          ///< TPDOs that were due and did not come
  std::uint64_t late = 0;          ///< TPDOs that came after the next SYNC, or twice
  std::uint64_t wrong_length = 0;  ///< TPDOs that were shorter than their mapping
  std::uint16_t short_pdo = 0;     ///< number of the newest of them; 0: none
  std::uint8_t short_bytes = 0;    ///< bytes that it had
  std::uint8_t mapped_bytes = 0;   ///< bytes of its mapping
  std::uint64_t unsent = 0;        ///< RPDOs with SYNC that the adapter did not take
};

/// Figures of the cycle since it started, beside motion::CycleStatistics. Plain value.
struct CanCycleCounters {
  std::uint64_t syncs_unsent = 0;    ///< SYNCs that the adapter did not take
  std::uint64_t rpdos_unsent = 0;    ///< RPDOs with SYNC that the adapter did not take
  std::uint64_t acyclic_unsent = 0;  ///< frames of the owner that the adapter cannot carry, or that were lost with it
  std::uint64_t foreign_frames = 0;  ///< frames with an identifier that only this master sends
  std::uint64_t stale_frames = 0;    ///< TPDOs that came after the next SYNC, or twice
  std::uint64_t flooded_cycles = 0;  ///< cycles that received no further because too many frames waited
};

}  // namespace driveline::canopen
