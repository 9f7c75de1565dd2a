#include "support/veth_pair.hpp"

#include <sched.h>
#include <unistd.h>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace driveline::bench {

namespace {

/// Root in a user namespace is sufficient for network namespaces and interfaces.
bool become_root_of_user_namespace() {
  const auto user = getuid();
  const auto group = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  std::ofstream{"/proc/self/setgroups"} << "deny";
  std::ofstream{"/proc/self/uid_map"} << "0 " << user << " 1";
  std::ofstream{"/proc/self/gid_map"} << "0 " << group << " 1";
  return true;
}

bool run_quietly(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

}  // namespace

std::string enter_private_network() {
  if (unshare(CLONE_NEWNET) == 0 || become_root_of_user_namespace()) return {};
  return std::string("no network namespace of our own: ") + std::strerror(errno);
}

void raise_loopback() {
  static_cast<void>(run_quietly("ip link set dev lo up"));
}

std::optional<VethPair> make_veth_pair(const std::string& name) {
  VethPair pair{name + "-near", name + "-far"};
  const bool made = run_quietly("ip link add name " + pair.near + " type veth peer name " + pair.far) &&
                    run_quietly("ip link set dev " + pair.near + " up") &&
                    run_quietly("ip link set dev " + pair.far + " up");
  if (!made) return std::nullopt;
  return pair;
}

}  // namespace driveline::bench
