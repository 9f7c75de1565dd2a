#include "network_namespace.hpp"

#include <fcntl.h>
#include <grp.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::endpoint {
namespace {

constexpr unsigned kNobody = 65534;
constexpr rlim_t kMaxFiles = 256;

Outcome<void> write_file(const char* path, const std::string& text) {
  const rt::FileDescriptor file{::open(path, O_WRONLY | O_CLOEXEC)};
  const bool done = file.valid() && ::write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (!done) return failed(path);
  return {};
}

/// Maps the user and group to root inside the new user namespace.
Outcome<void> map_to_root(unsigned user, unsigned group) {
  return write_file("/proc/self/setgroups", "deny")
      .and_then([&] { return write_file("/proc/self/uid_map", "0 " + std::to_string(user) + " 1"); })
      .and_then([&] { return write_file("/proc/self/gid_map", "0 " + std::to_string(group) + " 1"); });
}

Outcome<void> keep_net_admin_alone() {
  __user_cap_header_struct header{};
  header.version = _LINUX_CAPABILITY_VERSION_3;
  std::array<__user_cap_data_struct, 2> data{};
  data[0].effective = data[0].permitted = 1U << CAP_NET_ADMIN;
  if (::syscall(SYS_capset, &header, data.data()) != 0) return failed("capabilities cannot be dropped");
  return {};
}

}  // namespace

Outcome<void> enter_own_network() {
  if (::unshare(CLONE_NEWNET) == 0) return {};
  const unsigned user = ::getuid();
  const unsigned group = ::getgid();
  if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0) return map_to_root(user, group);
  return failed(
      "the device's IP stack needs a network namespace: this process has no CAP_SYS_ADMIN, and user namespaces are not "
      "allowed "
      "(kernel.unprivileged_userns_clone, user.max_user_namespaces)");
}

Outcome<void> drop_privileges() {
  for (unsigned capability = 0; ::prctl(PR_CAPBSET_READ, capability) >= 0; ++capability) {
    // Only CAP_SETPCAP can reduce the bounding set; a process without it could gain nothing from the set.
    static_cast<void>(::prctl(PR_CAPBSET_DROP, capability));
  }
  if (::prctl(PR_SET_KEEPCAPS, 1) != 0) return failed("PR_SET_KEEPCAPS");
  // A user namespace of this process does not map kNobody: there the calls fail and the user does not change.
  static_cast<void>(::setgroups(0, nullptr));
  static_cast<void>(::setresgid(kNobody, kNobody, kNobody));
  static_cast<void>(::setresuid(kNobody, kNobody, kNobody));
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return failed("PR_SET_NO_NEW_PRIVS");
  const rlimit files{kMaxFiles, kMaxFiles};
  if (::setrlimit(RLIMIT_NOFILE, &files) != 0) return failed("RLIMIT_NOFILE");
  const rlimit none{0, 0};
  static_cast<void>(::setrlimit(RLIMIT_CORE, &none));
  return keep_net_admin_alone();
}

}  // namespace driveline::endpoint
