#pragma once

#include <optional>
#include <string>

namespace driveline::bench {

/// Moves the process into a private network namespace, so that interfaces can be created without touching those of the
/// machine. Works for root, and for other users if the kernel allows user namespaces. To be called before any thread is
/// created: only later threads inherit the namespace. Returns why it failed, or an empty string.
[[nodiscard]] std::string enter_private_network();

/// Brings up the loopback interface of that network, for programs that talk to themselves.
void raise_loopback();

/// Two network interfaces joined by a virtual cable.
struct VethPair {
  std::string near;
  std::string far;
};
/// Creates such a pair; nothing: the kernel or `ip` cannot.
[[nodiscard]] std::optional<VethPair> make_veth_pair(const std::string& name);

}  // namespace driveline::bench
