#pragma once

#include "outcome.hpp"

namespace driveline::endpoint {

/// Moves this process into a network namespace of its own, which has nothing but a loopback interface. With
/// CAP_SYS_ADMIN directly, else inside a user namespace where the kernel allows it. The process must have one thread.
[[nodiscard]] Outcome<void> enter_own_network();

/// Gives up everything but CAP_NET_ADMIN, which in the own network namespace goes no further than this network and is
/// needed when the master sets another address; becomes nobody if it was root; nothing that it starts gets more.
[[nodiscard]] Outcome<void> drop_privileges();

}  // namespace driveline::endpoint
