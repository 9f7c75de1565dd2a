#pragma once

#include <chrono>
#include <cstddef>
#include "driveline/runtime/error.hpp"

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// How long a cycle waits for its frames, from the grid time on: the rest of the period is for calculating the
/// setpoints.
[[nodiscard]] constexpr std::chrono::nanoseconds receive_window(std::chrono::nanoseconds period) noexcept {
  return period * 3 / 4;
}

/// Time of the cyclic frames of the busiest cycle on a 100 Mbit/s wire, and the room beside them.
struct WireBudget {
  std::chrono::nanoseconds frames{};  ///< for which the frames occupy the wire
  std::chrono::nanoseconds line{};    ///< travel time of a frame through all slaves and back
  bool line_measured = false;         ///< by the receive times of the ports; else 1 us a slave is assumed
  std::chrono::nanoseconds period{};
  std::size_t acyclic_bytes = 0;    ///< of acyclic frames that fit into a cycle beside the process data
  std::size_t longest_mailbox = 0;  ///< frame with the largest mailbox of the line; 0: no mailboxes
  /// From the first bit sent to the last one back.
  [[nodiscard]] std::chrono::nanoseconds total() const noexcept { return frames + line; }
  /// Share of the period, from 0; 1 is the whole period.
  [[nodiscard]] double utilisation() const noexcept {
    return static_cast<double>(total().count()) / static_cast<double>(period.count());
  }
};

/// After Master::configure(). Calculates the budget. Bytes for acyclic work are those of the file, else what the cyclic
/// frames leave.
[[nodiscard]] WireBudget wire_budget(const ecat_master::Master& master, const LineConfig& config);

/// Checks that answers can be back while the cycle waits for them. For a simulated line in this process only the delays
/// of slaves and cables count, because its frames take no time on the wire.
[[nodiscard]] Result<void> check_budget(const WireBudget& budget, bool on_interface);

/// One line on the wire time of the cycle, and further ones with warnings.
[[nodiscard]] std::string describe(const WireBudget& budget, bool on_interface);

}  // namespace driveline::runtime
