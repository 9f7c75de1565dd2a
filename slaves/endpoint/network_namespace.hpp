#pragma once

#include "outcome.hpp"

namespace driveline::endpoint {

/// Moves this process into a new network namespace that has only a loopback interface: directly with CAP_SYS_ADMIN,
/// else inside a user namespace if the kernel allows it. The process must have a single thread.
[[nodiscard]] Outcome<void> enter_own_network();

/// Drops all privileges except CAP_NET_ADMIN, which is limited to the new network namespace and needed to change the
/// address; a root process becomes user 65534. Programs that it starts cannot gain privileges.
[[nodiscard]] Outcome<void> drop_privileges();

}  // namespace driveline::endpoint
