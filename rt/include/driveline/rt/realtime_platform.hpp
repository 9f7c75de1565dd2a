#pragma once

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

/// What kernel and machine contribute to, or withhold from, a real-time thread on `cpu` (none: on any CPU): preemption
/// model, throttling of real-time threads, CPU isolation, other real-time threads there, frequency governor. Each item
/// says what would be better. Reads files: not for the cycle.
[[nodiscard]] std::vector<RealtimeItem> inspect_platform(const PlatformSource& source, std::optional<int> cpu);

/// The highest-numbered CPU other than `cpu` that the calling thread may use; nothing if there is no other.
[[nodiscard]] std::optional<int> allowed_cpu_besides(int cpu) noexcept;

/// Whether `cpu` is in a list as the kernel writes it, such as "0-1,4".
[[nodiscard]] bool cpu_list_contains(std::string_view list, int cpu) noexcept;

}  // namespace driveline::rt
