#pragma once

#include <array>
#include <chrono>
#include <cstdint>

#include "driveline/motion/cycle/cycle_trace.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "node_table.hpp"

namespace driveline::canopen {

/// What happened in a period, from its SYNC until the outputs of the next one are known.
struct PeriodRecord {
  rt::CycleStart start{};                                              ///< of its SYNC
  std::chrono::nanoseconds sync_late{0};                               ///< SYNC left after the grid instant
  std::chrono::nanoseconds round_trip{0};                              ///< from SYNC to the last TPDO; 0: not all came
  std::array<std::chrono::nanoseconds, motion::kCyclePhases> spent{};  ///< by phase
  NodeTable::Verdict verdict{};
  std::uint32_t wrong_length = 0;   ///< TPDOs that were too short
  std::uint32_t stale = 0;          ///< TPDOs that answered an earlier SYNC
  std::uint32_t late = 0;           ///< those of them that were missing there
  std::uint32_t foreign = 0;        ///< frames with an identifier that only this master sends
  bool flooded = false;             ///< more frames waited than a cycle takes
  bool synced = false;              ///< SYNC was sent
  bool counted = true;              ///< in the statistics
  std::uint64_t bits = 0;           ///< bits of all frames
  float bus_load = 0.0F;            ///< share of the time until the next SYNC
  std::uint8_t send_errors = 0;     ///< transmit error counter of the adapter
  std::uint8_t receive_errors = 0;  ///< receive error counter of the adapter

  /// Work of the thread in this phase. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds& of(motion::CyclePhase phase) noexcept {
    return spent[static_cast<std::size_t>(phase)];
  }
};

}  // namespace driveline::canopen
