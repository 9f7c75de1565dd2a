#pragma once

#include <chrono>

namespace driveline::runtime {

/// [commands] of a line description: commands to its axes over DDS.
struct CommandConfig {
  /// A client that does not renew its leases for so long has died: its axes come to rest, and are free.
  std::chrono::nanoseconds lease_timeout = std::chrono::milliseconds{500};
  bool insecure = false;  ///< without DDS Security: whoever is in the network may command
};

}  // namespace driveline::runtime
