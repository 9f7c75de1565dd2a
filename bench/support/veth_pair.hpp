#pragma once

#include <optional>
#include <string>

namespace driveline::bench {

/// Moves the process into a network namespace of its own, so that interfaces can be made without touching the
/// machine's. Works as root, and without where the kernel allows user namespaces. To be called before any thread is
/// made: later ones are born into the namespace. Returns why it does not work, or an empty string.
[[nodiscard]] std::string enter_private_network();

/// Takes the loopback interface of that network into service, for programs that talk to themselves.
void raise_loopback();

/// Two network interfaces joined by a virtual cable.
struct VethPair {
  std::string near;
  std::string far;
};
/// Makes such a pair; nothing when the kernel or `ip` cannot.
[[nodiscard]] std::optional<VethPair> make_veth_pair(const std::string& name);

}  // namespace driveline::bench
