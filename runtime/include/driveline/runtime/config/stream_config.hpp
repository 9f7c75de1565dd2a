#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "driveline/trajectory/stream_curve.hpp"

namespace driveline::runtime {

/// Users who may stream, besides root and the user that runs the line.
struct StreamUsers {
  std::vector<uid_t> users{};    ///< permitted users
  std::optional<gid_t> group{};  ///< permitted group: all its members
};

/// How the setpoints of clients become those of the axes.
struct ClientStreamSettings {
  /// Interpolation between the setpoints.
  trajectory::StreamMethod method = trajectory::StreamMethod::kCubic;
  /// A client that writes no record for this long is considered dead: its axes come to rest and are free.
  std::chrono::nanoseconds keep_alive = std::chrono::milliseconds{100};
  /// Delay from the arrival of the first setpoint to its execution: the jitter that is tolerated.
  std::chrono::nanoseconds delay = std::chrono::milliseconds{5};
};

/// [stream] of a line description: setpoints from other processes.
struct StreamConfig {
  std::filesystem::path socket;   ///< socket for clients
  std::vector<std::size_t> axes;  ///< numbers of the axes that accept streams; default: all
  StreamUsers allowed;            ///< permitted users
  ClientStreamSettings settings;  ///< treatment of the setpoints
};

}  // namespace driveline::runtime
