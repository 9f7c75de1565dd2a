#include "confinement.hpp"

#include <grp.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace driveline::bridge {
namespace {

constexpr rlim_t kMaxMemory = 256U << 20;
constexpr rlim_t kMaxFiles = 64;
/// Stack size for threads of Fast DDS, which would have 8 MiB each.
constexpr std::size_t kThreadStack = 512 * 1024;

std::string failed(const char* what) {
  return std::string{what} + ": " + std::strerror(errno);
}

void become_ordinary(int realtime_cpu) {
  const sched_param no_priority{};
  static_cast<void>(::sched_setscheduler(0, SCHED_OTHER, &no_priority));
  cpu_set_t cpus;
  if (realtime_cpu < 0 || realtime_cpu >= CPU_SETSIZE || ::sched_getaffinity(0, sizeof(cpus), &cpus) != 0) return;
  CPU_CLR(static_cast<std::size_t>(realtime_cpu), &cpus);
  if (CPU_COUNT(&cpus) > 0) static_cast<void>(::sched_setaffinity(0, sizeof(cpus), &cpus));
}

/// Changes root to `identity`. Any other user stays unchanged, because it has no such privilege.
std::string give_up_user(const Identity& identity) {
  if (::geteuid() != 0 && ::getuid() != 0) return {};
  const auto& [user, group] = identity;
  if (::setgroups(0, nullptr) != 0) return failed("cannot drop the groups of root");
  if (::setresgid(group, group, group) != 0) return failed("cannot drop the group of root");
  if (::setresuid(user, user, user) != 0) return failed("cannot drop the rights of root");
  return {};
}

std::string give_up_capabilities() {
  static_cast<void>(::prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0));
  __user_cap_header_struct header{};
  header.version = _LINUX_CAPABILITY_VERSION_3;
  std::array<__user_cap_data_struct, 2> none{};
  if (::syscall(SYS_capset, &header, none.data()) != 0) return failed("cannot drop capabilities");
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return failed("PR_SET_NO_NEW_PRIVS");
  return {};
}

/// Limits a resource to `most`. A lower limit stays, because only root can raise it.
bool limit(__rlimit_resource resource, rlim_t most) {
  rlimit limits{};
  if (::getrlimit(resource, &limits) != 0) return false;
  limits.rlim_cur = limits.rlim_max = std::min(most, limits.rlim_max);
  return ::setrlimit(resource, &limits) == 0;
}

std::string limit_resources() {
  if (!limit(RLIMIT_NOFILE, kMaxFiles)) return failed("RLIMIT_NOFILE");
  if (!limit(RLIMIT_CORE, 0)) return failed("RLIMIT_CORE");
  if (!kSanitized && !limit(RLIMIT_DATA, kMaxMemory)) return failed("RLIMIT_DATA");
  return {};
}

void make_thread_stacks_small() {
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  static_cast<void>(pthread_attr_setstacksize(&attributes, kThreadStack));
  static_cast<void>(pthread_setattr_default_np(&attributes));
  pthread_attr_destroy(&attributes);
}

}  // namespace

std::string give_up_privileges(int realtime_cpu, Identity identity) {
  become_ordinary(realtime_cpu);
  for (unsigned capability = 0; ::prctl(PR_CAPBSET_READ, capability) >= 0; ++capability) {
    // Dropping from the bounding set requires CAP_SETPCAP; without it there is nothing to gain from dropping.
    static_cast<void>(::prctl(PR_CAPBSET_DROP, capability));
  }
  if (auto wrong = give_up_user(identity); !wrong.empty()) return wrong;
  for (auto* const step : {give_up_capabilities, limit_resources}) {
    if (auto wrong = step(); !wrong.empty()) return wrong;
  }
  make_thread_stacks_small();
  return {};
}

}  // namespace driveline::bridge
