#pragma once

#include <optional>
#include <string>

#include "driveline/rt/realtime_platform.hpp"
#include "driveline/rt/realtime_report.hpp"

/// One function per fact about the machine. Each reads its files below `source.root`, and says what was found, what is
/// better, what the difference costs and how it is mended. A file that cannot be read is no finding, unless the text
/// of the item says so.
namespace driveline::rt::checks {

/// Where the thread is to run; nothing: on any CPU.
using Cpu = std::optional<int>;

// Of the kernel.
[[nodiscard]] RealtimeItem preemption(const PlatformSource& source);
[[nodiscard]] RealtimeItem throttling(const PlatformSource& source);
[[nodiscard]] RealtimeItem group_scheduling(const PlatformSource& source);
[[nodiscard]] RealtimeItem clock_source(const PlatformSource& source);
[[nodiscard]] RealtimeItem virtual_machine(const PlatformSource& source);

// Of the CPU that the thread has.
[[nodiscard]] RealtimeItem isolation(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem timer_tick(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem rcu_callbacks(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem interrupts(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem governor(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem idle_states(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem siblings(const PlatformSource& source, Cpu cpu);
[[nodiscard]] RealtimeItem management_interrupts(const PlatformSource& source, Cpu cpu);

/// Real-time threads of other processes that are pinned to `cpu` alone, where they would delay ours. Kernel threads and
/// threads of the calling process do not count.
[[nodiscard]] RealtimeItem neighbours(const PlatformSource& source, Cpu cpu);

// What the checks have in common.

/// First line of a file of /proc or /sys; nothing if it cannot be read.
[[nodiscard]] std::optional<std::string> first_line(const std::string& path);
/// An item that is fine.
[[nodiscard]] RealtimeItem fine(std::string name, std::string requested, std::string found);
/// An item with what it costs, and how it is mended.
[[nodiscard]] RealtimeItem found(RealtimeItem item, Cost cost, std::string consequence, std::string remedy);
/// The value of `name=` on the kernel's command line; empty if it is there without a value, nothing if it is not there.
[[nodiscard]] std::optional<std::string> boot_parameter(const PlatformSource& source, const std::string& name);

}  // namespace driveline::rt::checks
