#pragma once

#include <chrono>
#include <cstddef>
#include "driveline/runtime/error.hpp"

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// How long a cycle waits for its frames, from the grid on: the rest of the period is for what is made of them.
[[nodiscard]] constexpr std::chrono::nanoseconds receive_window(std::chrono::nanoseconds period) noexcept {
  return period * 3 / 4;
}

/// What the cyclic frames of the busiest cycle cost on a 100 Mbit/s wire, and what they leave.
struct WireBudget {
  std::chrono::nanoseconds frames{};  ///< the wire is occupied
  std::chrono::nanoseconds line{};    ///< way of a frame through all slaves and back
  bool line_measured = false;         ///< by the receive times of the ports; else 1 us a slave is assumed
  std::chrono::nanoseconds period{};
  std::size_t acyclic_bytes = 0;    ///< longest frame beside the process data that leaves the next cycle its time
  std::size_t longest_mailbox = 0;  ///< frame with the largest mailbox of the line; 0: no mailboxes
  /// From the first bit sent to the last one back.
  [[nodiscard]] std::chrono::nanoseconds total() const noexcept { return frames + line; }
  /// Share of the period, 1 is all of it.
  [[nodiscard]] double utilisation() const noexcept {
    return static_cast<double>(total().count()) / static_cast<double>(period.count());
  }
};

/// After Master::configure(). Bytes for acyclic work are those of the file, else what the cyclic frames leave.
[[nodiscard]] WireBudget wire_budget(const ecat_master::Master& master, const LineConfig& config);

/// Whether the answers can be back while the cycle waits for them. A simulated line in this process has the delays of
/// its slaves and cables, but its frames take no time: it is asked for the former only. Failure (status 1).
[[nodiscard]] Result<void> check_budget(const WireBudget& budget, bool on_interface);

/// One line on what the cycle takes of the wire, and further ones on what will not work as it should.
[[nodiscard]] std::string describe(const WireBudget& budget, bool on_interface);

}  // namespace driveline::runtime
