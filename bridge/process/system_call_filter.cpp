// System call filter of a publishing bridge: allows what Fast DDS does with sockets and time, memory, and the shutdown.
// Refuses everything that opens a file (except for shared memory, if requested), starts a program, or accesses another
// process.
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>

#include "confinement.hpp"

namespace driveline::bridge {
namespace {

// SCMP_SYS gives a negative number for a call that an architecture does not have; libseccomp ignores its rule.
constexpr int kAllowed[] = {
    // sockets that exist, or that Fast DDS opens for a new subscriber
    SCMP_SYS(sendto),
    SCMP_SYS(sendmsg),
    SCMP_SYS(recvfrom),
    SCMP_SYS(recvmsg),
    SCMP_SYS(bind),
    SCMP_SYS(connect),
    SCMP_SYS(getsockname),
    SCMP_SYS(getpeername),
    SCMP_SYS(setsockopt),
    SCMP_SYS(getsockopt),
    SCMP_SYS(shutdown),
    SCMP_SYS(close),
    // waiting
    SCMP_SYS(ppoll),
    SCMP_SYS(pselect6),
    SCMP_SYS(epoll_ctl),
    SCMP_SYS(epoll_pwait),
    SCMP_SYS(eventfd2),
    SCMP_SYS(timerfd_settime),
    SCMP_SYS(futex),
    SCMP_SYS(nanosleep),
    SCMP_SYS(clock_nanosleep),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(clock_getres),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(sched_yield),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(setitimer),
    // messages, and existing descriptors
    SCMP_SYS(read),
    SCMP_SYS(readv),
    SCMP_SYS(write),
    SCMP_SYS(writev),
    SCMP_SYS(fcntl),
    SCMP_SYS(fstat),
    SCMP_SYS(lseek),
    // memory; executable memory is refused below
    SCMP_SYS(brk),
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(madvise),
    // threads
    SCMP_SYS(set_robust_list),
    SCMP_SYS(rseq),
    SCMP_SYS(gettid),
    SCMP_SYS(getpid),
    SCMP_SYS(getuid),
    SCMP_SYS(geteuid),
    SCMP_SYS(getgid),
    SCMP_SYS(getegid),
    SCMP_SYS(sched_getaffinity),
    SCMP_SYS(sched_getparam),
    SCMP_SYS(sched_getscheduler),
    SCMP_SYS(getrandom),
    SCMP_SYS(uname),
    SCMP_SYS(sysinfo),
    SCMP_SYS(getrusage),
    // signals to itself: abort(); signals to other processes are refused below
    SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigaltstack),
    // shutdown
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(poll),
    SCMP_SYS(select),
    SCMP_SYS(epoll_wait),
    SCMP_SYS(time),
    SCMP_SYS(alarm),
};

/// Additional calls for shared memory: opening a port for a new reader, recreating it after its reader has died, and
/// removing it; and its named mutex, which glibc first creates under another name. Mapped memory needs no file here.
constexpr int kAllowedOnFiles[] = {
    SCMP_SYS(openat), SCMP_SYS(ftruncate), SCMP_SYS(fchmod), SCMP_SYS(flock),  SCMP_SYS(newfstatat),
    SCMP_SYS(linkat), SCMP_SYS(unlinkat),  SCMP_SYS(link),   SCMP_SYS(unlink),
};

constexpr std::uint64_t kSocketFamilies[] = {AF_INET, AF_NETLINK};
/// For sockets; and for a log that may be a terminal, where TIOCSTI would inject input.
constexpr std::uint64_t kIoctlRequests[] = {TCGETS,       FIONBIO,     FIONREAD,    SIOCGIFCONF,
                                            SIOCGIFFLAGS, SIOCGIFADDR, SIOCGIFINDEX};

/// Calls that never occur by mistake: they end the process.
constexpr int kFatal[] = {SCMP_SYS(execve),
                          SCMP_SYS(execveat),
                          SCMP_SYS(ptrace),
                          SCMP_SYS(process_vm_readv),
                          SCMP_SYS(process_vm_writev),
                          SCMP_SYS(init_module),
                          SCMP_SYS(finit_module),
                          SCMP_SYS(bpf),
                          SCMP_SYS(perf_event_open),
                          SCMP_SYS(mount),
                          SCMP_SYS(setns),
                          SCMP_SYS(unshare)};

/// Builds a filter. The first error is kept; what is added after it has no effect.
class Filter {
 public:
  Filter() : context_(::seccomp_init(SCMP_ACT_ERRNO(EPERM)), ::seccomp_release) {
    if (!context_) error_ = ENOMEM;
    // For all threads, because the threads of Fast DDS are already running.
    if (error_ == 0) keep(::seccomp_attr_set(context_.get(), SCMP_FLTATR_CTL_TSYNC, 1));
    if (error_ == 0) keep(::seccomp_attr_set(context_.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS));
  }

  template <std::size_t kCount>
  void add(std::uint32_t action, const int (&calls)[kCount]) {
    for (const int call : calls) add(action, call);
  }
  void add(std::uint32_t action, int call) {
    if (error_ == 0) keep(::seccomp_rule_add(context_.get(), action, call, 0));
  }
  /// Allows a call if the bits `mask` of argument `index` have the value `value`.
  void allow_if(int call, unsigned index, std::uint64_t mask, std::uint64_t value) {
    if (error_ != 0) return;
    keep(::seccomp_rule_add(context_.get(), SCMP_ACT_ALLOW, call, 1, SCMP_CMP(index, SCMP_CMP_MASKED_EQ, mask, value)));
  }
  /// Applies the filter to this process. Returns 0 or the number of the first error.
  [[nodiscard]] int load() {
    if (error_ == 0) keep(::seccomp_load(context_.get()));
    return error_;
  }

 private:
  void keep(int result) { error_ = -result; }

  std::unique_ptr<void, decltype(&::seccomp_release)> context_;
  int error_ = 0;
};

Filter make_filter(bool shared_memory) {
  // The arguments compared here are 32 bits wide: the upper half of their registers is undefined.
  constexpr std::uint64_t kLower = 0xFFFFFFFF;
  const auto self = static_cast<std::uint64_t>(::getpid());
  Filter filter;
  filter.add(SCMP_ACT_KILL_PROCESS, kFatal);
  // glibc falls back to clone() without clone3(), whose flags a filter cannot read.
  filter.add(SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3));
  filter.add(SCMP_ACT_ALLOW, kAllowed);
  if (shared_memory) filter.add(SCMP_ACT_ALLOW, kAllowedOnFiles);
  filter.allow_if(SCMP_SYS(clone), 0, CLONE_THREAD, CLONE_THREAD);
  filter.allow_if(SCMP_SYS(mmap), 2, PROT_EXEC, 0);
  filter.allow_if(SCMP_SYS(mprotect), 2, PROT_EXEC, 0);
  for (const std::uint64_t family : kSocketFamilies) filter.allow_if(SCMP_SYS(socket), 0, kLower, family);
  for (const std::uint64_t request : kIoctlRequests) filter.allow_if(SCMP_SYS(ioctl), 1, kLower, request);
  filter.allow_if(SCMP_SYS(prlimit64), 0, kLower, 0);  // only its own limits
  filter.allow_if(SCMP_SYS(tgkill), 0, kLower, self);
  filter.allow_if(SCMP_SYS(kill), 0, kLower, self);
  return filter;
}

}  // namespace

std::string filter_system_calls(bool shared_memory) {
  if (kSanitized) return {};
  const int error = make_filter(shared_memory).load();
  if (error != 0) return std::string{"system calls cannot be filtered: "} + std::strerror(error);
  return {};
}

}  // namespace driveline::bridge
