#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// Root of the file tree that the facts about the machine are read from; tests use a made-up tree.
struct PlatformSource {
  std::string root;           ///< put before /proc and /sys; empty for the real ones
  std::string uname_version;  ///< `uname -v`

  /// The machine this runs on.
  [[nodiscard]] static PlatformSource this_machine();
};

/// What kernel and machine contribute to, or withhold from, a real-time thread on `cpu` (none: on any CPU). Of the
/// kernel: preemption model, throttling and group budget of real-time threads, clock source, virtual machine. Of the
/// CPU: isolation, timer tick, RCU callbacks, device interrupts, other real-time threads, hyper-threading, frequency
/// governor, idle states, management interrupts of the firmware. Each item that is not ok says what that costs and what
/// mends it. Reads files: not for the cycle.
[[nodiscard]] std::vector<RealtimeItem> inspect_platform(const PlatformSource& source, std::optional<int> cpu);

/// Time that a CPU has spent since the machine was started, in ticks of /proc/stat.
struct CpuTimes {
  std::uint64_t busy = 0;    ///< programs, kernel and interrupts
  std::uint64_t idle = 0;    ///< nothing to do, or waiting for a disk
  std::uint64_t stolen = 0;  ///< the hypervisor gave it to others
};

/// What `cpu` has done until now; nothing if there is no such CPU. Reads a file: not for the cycle.
[[nodiscard]] std::optional<CpuTimes> read_cpu_times(const PlatformSource& source, int cpu);

/// How busy `cpu` was between two readings: it should have nothing to do before the real-time thread comes.
[[nodiscard]] RealtimeItem inspect_load(int cpu, const CpuTimes& before, const CpuTimes& after);

/// The highest-numbered CPU other than `cpu` that the calling thread may use; nothing if there is no other.
[[nodiscard]] std::optional<int> allowed_cpu_besides(int cpu) noexcept;

/// Whether `cpu` is in a list as the kernel writes it, such as "0-1,4".
[[nodiscard]] bool cpu_list_contains(std::string_view list, int cpu) noexcept;

}  // namespace driveline::rt
