#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// Where the facts about the machine are read from; tests use an artificial file tree.
struct PlatformSource {
  std::string root;           ///< prefix of /proc and /sys; empty for the real ones
  std::string uname_version;  ///< output of `uname -v`

  /// The machine that this process runs on.
  [[nodiscard]] static PlatformSource this_machine();
};

/// Checks what the kernel and the machine do for or against a real-time thread on `cpu` (none: on any CPU). Kernel:
/// preemption model, throttling and group budget of real-time threads, clock source, virtual machine. CPU: isolation,
/// timer tick, RCU callbacks, device interrupts, other real-time threads, hyper-threading, frequency governor, idle
/// states, management interrupts of the firmware. Each item that is not ok states its cost and its remedy. Reads files:
/// not for the cycle.
[[nodiscard]] std::vector<RealtimeItem> inspect_platform(const PlatformSource& source, std::optional<int> cpu);

/// Time that a CPU has spent since boot, in ticks of /proc/stat.
struct CpuTimes {
  std::uint64_t busy = 0;    ///< running programs, the kernel and interrupts
  std::uint64_t idle = 0;    ///< idle, or waiting for a disk
  std::uint64_t stolen = 0;  ///< given to other guests by the hypervisor
};

/// Reads the times of `cpu` so far; nullopt if there is no such CPU. Reads a file: not for the cycle.
[[nodiscard]] std::optional<CpuTimes> read_cpu_times(const PlatformSource& source, int cpu);

/// Load of `cpu` between two readings: it should be idle before the real-time thread starts.
[[nodiscard]] RealtimeItem inspect_load(int cpu, const CpuTimes& before, const CpuTimes& after);

/// The highest-numbered CPU other than `cpu` that the calling thread may use; nullopt if there is none.
[[nodiscard]] std::optional<int> allowed_cpu_besides(int cpu) noexcept;

/// Whether `cpu` is in a list in the kernel's notation, such as "0-1,4".
[[nodiscard]] bool cpu_list_contains(std::string_view list, int cpu) noexcept;

}  // namespace driveline::rt
