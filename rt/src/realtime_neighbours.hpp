#pragma once

#include <optional>
#include <string>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// Real-time threads of programs that may run on `cpu` and nowhere else: two of them keep each other waiting. `root` is
/// put before /proc. Threads of the kernel are no neighbours, nor are those of the calling process.
[[nodiscard]] RealtimeItem inspect_neighbours(const std::string& root, std::optional<int> cpu);

}  // namespace driveline::rt
