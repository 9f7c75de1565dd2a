#pragma once

#include <optional>
#include <string>

#include "driveline/rt/realtime_platform.hpp"
#include "driveline/rt/realtime_report.hpp"

/// One function per fact about the machine. Each reads its files below `source.root` and states what was found, what is
/// better, the cost of the difference and the remedy. A file that cannot be read is not a finding, unless the text of
/// the item says so.
namespace driveline::rt::checks {

/// CPU of the thread; nullopt: any CPU.
using Cpu = std::optional<int>;

// Checks of the kernel.
[[nodiscard]] RealtimeItem preemption(const PlatformSource& source);
[[nodiscard]] RealtimeItem throttling(const PlatformSource& source);
[[nodiscard]] RealtimeItem group_scheduling(const PlatformSource& source);
[[nodiscard]] RealtimeItem clock_source(const PlatformSource& source);
[[nodiscard]] RealtimeItem virtual_machine(const PlatformSource& source);

// Checks of the CPU of the thread.
[[nodiscard]] RealtimeItem isolation(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem timer_tick(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem rcu_callbacks(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem interrupts(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem governor(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem idle_states(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem siblings(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem management_interrupts(const PlatformSource& source, Cpu cpu);

/// Lists real-time threads of other processes that are pinned to `cpu` alone, where they would delay the cycle. Kernel
/// threads and threads of the calling process do not count.
[[nodiscard]] RealtimeItem neighbours(const PlatformSource& source, Cpu cpu);

// Helpers of the checks.

/// First line of a file of /proc or /sys; nullopt if it cannot be read.
[[nodiscard]] std::optional<std::string> first_line(const std::string& path);
/// An item that is ok.
[[nodiscard]] RealtimeItem fine(std::string name, std::string requested, std::string found);
/// The item marked as not ok, with its cost and its remedy.
[[nodiscard]] RealtimeItem found(RealtimeItem item, Cost cost, std::string consequence, std::string remedy);
/// Value of `name=` on the kernel's command line; empty if it has no value, nullopt if it is absent.
[[nodiscard]] std::optional<std::string> boot_parameter(const PlatformSource& source, const std::string& name);

}  // namespace driveline::rt::checks
