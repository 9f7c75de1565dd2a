#pragma once

#include <chrono>
#include <cstddef>
#include <ctime>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "driveline/port/port_error.hpp"

namespace driveline::port {

/// How an interface holds frames back until their launch time (SO_TXTIME), according to the set-up of its queueing
/// discipline `etf` (tc-etf(8)).
struct LaunchTimes {
  clockid_t clock = CLOCK_TAI;  ///< clock on which the kernel reads launch times
  /// How long before its launch time a frame is taken out of the queue ("delta"): a frame handed over later may be
  /// discarded.
  std::chrono::nanoseconds ahead{};
  bool by_hardware = false;  ///< the network card holds the frame ("offload"), else a kernel timer does

  bool operator==(const LaunchTimes&) const = default;
};

/// Reads the launch times of an interface whose frames are handed over by `early` before they are to leave. Needs no
/// privileges. Errors: those of finding an interface, and of usable_launch_times().
[[nodiscard]] tl::expected<LaunchTimes, PortError> find_launch_times(const std::string& interface,
                                                                     std::chrono::nanoseconds early);

/// Checks whether the `etf` of an interface is usable. Error: kUnsupported when there is none, when it runs on a clock
/// other than CLOCK_TAI and CLOCK_MONOTONIC, or when it needs frames longer than `early` before they leave.
[[nodiscard]] tl::expected<LaunchTimes, PortError> usable_launch_times(const std::optional<LaunchTimes>& etf,
                                                                       const std::string& interface,
                                                                       std::chrono::nanoseconds early);

/// Reads the first `etf` at the interface with this index from `messages`, an answer of the kernel to a query for
/// queueing disciplines (rtnetlink(7), RTM_GETQDISC). Empty when there is none or the answer is damaged before it.
[[nodiscard]] std::optional<LaunchTimes> etf_in(std::span<const std::byte> messages, int interface_index) noexcept;

}  // namespace driveline::port
