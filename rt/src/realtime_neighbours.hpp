#pragma once

#include <optional>
#include <string>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// Real-time threads of other processes that are pinned to `cpu` alone, where they would delay ours. `root` is put
/// before /proc. Kernel threads and threads of the calling process do not count.
[[nodiscard]] RealtimeItem inspect_neighbours(const std::string& root, std::optional<int> cpu);

}  // namespace driveline::rt
