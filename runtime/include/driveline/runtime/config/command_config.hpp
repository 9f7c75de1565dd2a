#pragma once

#include <chrono>

namespace driveline::runtime {

/// [commands] of a line description: commands to its axes over DDS.
struct CommandConfig {
  /// A client that does not renew its leases for this long is considered dead: its axes come to rest and are free.
  std::chrono::nanoseconds lease_timeout = std::chrono::milliseconds{500};
  bool insecure = false;  ///< without DDS Security: anyone in the network may command the axes
};

}  // namespace driveline::runtime
