#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "driveline/trajectory/stream_curve.hpp"

namespace driveline::runtime {

/// Who may stream besides root and the user that runs the line.
struct StreamUsers {
  std::vector<uid_t> users{};    ///< these
  std::optional<gid_t> group{};  ///< and the members of this group
};

/// How setpoints of clients become those of the axes.
struct StreamSettings {
  /// Between the setpoints.
  trajectory::StreamMethod method = trajectory::StreamMethod::kCubic;
  /// A client that writes no record for so long has died: its axes come to rest, and are free.
  std::chrono::nanoseconds keep_alive = std::chrono::milliseconds{100};
  /// From the arrival of the first setpoint to the moment that it is for: the jitter that may be.
  std::chrono::nanoseconds delay = std::chrono::milliseconds{5};
};

/// [stream] of a line description: setpoints out of other processes.
struct StreamConfig {
  std::filesystem::path socket;   ///< where clients connect
  std::vector<std::size_t> axes;  ///< numbers of those that may be streamed to; all when left out
  StreamUsers allowed;            ///< who may connect
  StreamSettings settings;        ///< what becomes of the setpoints
};

}  // namespace driveline::runtime
