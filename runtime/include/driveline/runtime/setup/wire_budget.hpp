#pragma once

#include <chrono>
#include <cstddef>
#include "driveline/runtime/error.hpp"

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// Returns how long a cycle waits for its frames, from the grid time on; the rest of the period is for the calculation
/// of the setpoints.
[[nodiscard]] constexpr std::chrono::nanoseconds receive_window(std::chrono::nanoseconds period) noexcept {
  return period * 3 / 4;
}

/// Wire time of the cyclic frames of the busiest cycle at 100 Mbit/s, and the remaining room.
struct WireBudget {
  std::chrono::nanoseconds frames{};  ///< time for which the frames occupy the wire
  std::chrono::nanoseconds line{};    ///< travel time of a frame through all slaves and back
  bool line_measured = false;  ///< measured by the receive times of the ports; otherwise 1 us per slave is assumed
  std::chrono::nanoseconds period{};
  std::size_t acyclic_bytes = 0;    ///< bytes of acyclic frames that fit into a cycle in addition to the process data
  std::size_t longest_mailbox = 0;  ///< length of a frame with the largest mailbox of the line; 0: no mailboxes
  /// Returns the time from the first bit sent to the last bit received.
  [[nodiscard]] std::chrono::nanoseconds total() const noexcept { return frames + line; }
  /// Returns the share of the period, from 0; 1 is the whole period.
  [[nodiscard]] double utilisation() const noexcept {
    return static_cast<double>(total().count()) / static_cast<double>(period.count());
  }
};

/// Calculates the budget. Call after Master::configure(). The bytes for acyclic frames come from the file, else they
/// are what the cyclic frames leave free.
[[nodiscard]] WireBudget wire_budget(const ecat_master::Master& master, const LineConfig& config);

/// Checks that answers can return while the cycle waits for them. For a simulated line in this process only the delays
/// of slaves and cables count, because its frames take no time on the wire.
[[nodiscard]] Result<void> check_budget(const WireBudget& budget, bool on_interface);

/// Returns one line about the wire time of the cycle, and further lines with warnings.
[[nodiscard]] std::string describe(const WireBudget& budget, bool on_interface);

}  // namespace driveline::runtime
