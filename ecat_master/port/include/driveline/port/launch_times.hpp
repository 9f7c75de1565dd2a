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

/// How an interface holds frames back until the instant at which each is to leave (SO_TXTIME): as its queueing
/// discipline `etf` is set up (tc-etf(8)).
struct LaunchTimes {
  clockid_t clock = CLOCK_TAI;  ///< that the kernel reads launch times on
  /// How long before its launch time a frame is taken out of the queue ("delta"): one that comes later may be
  /// discarded.
  std::chrono::nanoseconds ahead{};
  bool by_hardware = false;  ///< the network card holds the frame ("offload"), else a timer of the kernel

  bool operator==(const LaunchTimes&) const = default;
};

/// The launch times of an interface whose frames are handed over by `early` before them. Needs no privileges. Errors:
/// those of finding an interface, and of usable_launch_times().
[[nodiscard]] tl::expected<LaunchTimes, PortError> find_launch_times(const std::string& interface,
                                                                     std::chrono::nanoseconds early);

/// Whether the `etf` of an interface will do. Error: kUnsupported, where there is none, it is on a clock other than
/// CLOCK_TAI and CLOCK_MONOTONIC, or takes frames longer than `early` before they leave.
[[nodiscard]] tl::expected<LaunchTimes, PortError> usable_launch_times(const std::optional<LaunchTimes>& etf,
                                                                       const std::string& interface,
                                                                       std::chrono::nanoseconds early);

/// What `messages`, an answer of the kernel to a question for queueing disciplines (rtnetlink(7), RTM_GETQDISC), says
/// of the first `etf` at the interface of this index. Nothing: there is none, or the answer is damaged before it.
[[nodiscard]] std::optional<LaunchTimes> etf_in(std::span<const std::byte> messages, int interface_index) noexcept;

}  // namespace driveline::port
