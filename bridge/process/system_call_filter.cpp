// System call filter of a publishing bridge: allows what Fast DDS does with sockets and time, memory, and the shutdown.
// Refuses everything that opens a file (except for shared memory, if requested), starts a program, or accesses another
// process.
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <vector>

#include "confinement.hpp"

namespace driveline::bridge {
namespace {

#if defined(__x86_64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_AARCH64;
#else
#error "the number of this architecture in linux/audit.h is missing here"
#endif

constexpr unsigned kAllowed[] = {
    // sockets that exist, or that Fast DDS opens for a new subscriber
    SYS_sendto,
    SYS_sendmsg,
    SYS_recvfrom,
    SYS_recvmsg,
    SYS_bind,
    SYS_connect,
    SYS_getsockname,
    SYS_getpeername,
    SYS_setsockopt,
    SYS_getsockopt,
    SYS_shutdown,
    SYS_close,
    // waiting
    SYS_ppoll,
    SYS_pselect6,
    SYS_epoll_ctl,
    SYS_epoll_pwait,
    SYS_eventfd2,
    SYS_timerfd_settime,
    SYS_futex,
    SYS_nanosleep,
    SYS_clock_nanosleep,
    SYS_clock_gettime,
    SYS_clock_getres,
    SYS_gettimeofday,
    SYS_sched_yield,
    SYS_restart_syscall,
    SYS_setitimer,
    // messages, and existing descriptors
    SYS_read,
    SYS_readv,
    SYS_write,
    SYS_writev,
    SYS_fcntl,
    SYS_fstat,
    SYS_lseek,
    // memory; executable memory is refused below
    SYS_brk,
    SYS_munmap,
    SYS_mremap,
    SYS_madvise,
    // threads
    SYS_set_robust_list,
    SYS_rseq,
    SYS_gettid,
    SYS_getpid,
    SYS_getuid,
    SYS_geteuid,
    SYS_getgid,
    SYS_getegid,
    SYS_sched_getaffinity,
    SYS_sched_getparam,
    SYS_sched_getscheduler,
    SYS_getrandom,
    SYS_uname,
    SYS_sysinfo,
    SYS_getrusage,
    // signals to itself: abort(); signals to other processes are refused below
    SYS_rt_sigaction,
    SYS_rt_sigprocmask,
    SYS_rt_sigreturn,
    SYS_sigaltstack,
    // shutdown
    SYS_exit,
    SYS_exit_group,
#ifdef __x86_64__
    SYS_poll,
    SYS_select,
    SYS_epoll_wait,
    SYS_time,
    SYS_alarm,
#endif
};

/// Additional calls for shared memory: opening a port for a new reader, recreating it after its reader has died, and
/// removing it; and its named mutex, which glibc first creates under another name. Mapped memory needs no file here.
constexpr unsigned kAllowedOnFiles[] = {
    SYS_openat, SYS_ftruncate, SYS_fchmod, SYS_flock, SYS_newfstatat, SYS_linkat, SYS_unlinkat,
#ifdef __x86_64__
    SYS_link,   SYS_unlink,
#endif
};

/// Calls that never occur by mistake: they end the process.
constexpr unsigned kFatal[] = {
    SYS_execve,      SYS_execveat,     SYS_ptrace, SYS_process_vm_readv, SYS_process_vm_writev,
    SYS_init_module, SYS_finit_module, SYS_bpf,    SYS_perf_event_open,  SYS_mount,
    SYS_setns,       SYS_unshare};

constexpr unsigned kDeny = SECCOMP_RET_ERRNO | EPERM;

using Program = std::vector<sock_filter>;

constexpr unsigned field(std::size_t offset) {
  return static_cast<unsigned>(offset);
}
/// Lower half of an argument, sufficient for all comparisons here.
constexpr unsigned argument(std::size_t index) {
  return field(offsetof(seccomp_data, args) + index * sizeof(std::uint64_t));
}

void load(Program& program, unsigned offset) {
  program.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offset));
}
void answer(Program& program, unsigned value) {
  program.push_back(BPF_STMT(BPF_RET | BPF_K, value));
}
/// Returns `result` if the loaded value is `value`.
void answer_if(Program& program, unsigned value, unsigned result) {
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1));
  answer(program, result);
}

/// System call `number`: allowed if argument `index` has one of `values`, otherwise refused.
template <std::size_t kCount>
void allow_values(Program& program, unsigned number, std::size_t index, const std::array<unsigned, kCount>& values) {
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, 2 + 2 * kCount));
  load(program, argument(index));
  for (const unsigned value : values) answer_if(program, value, SECCOMP_RET_ALLOW);
  answer(program, kDeny);
}

/// System call `number`: allowed if argument `index` has all bits of `mask` (`set`) or none of them.
void allow_bits(Program& program, unsigned number, std::size_t index, unsigned mask, bool set) {
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, 4));
  load(program, argument(index));
  program.push_back(
      BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, mask, static_cast<__u8>(set ? 0 : 1), static_cast<__u8>(set ? 1 : 0)));
  answer(program, SECCOMP_RET_ALLOW);
  answer(program, kDeny);
}

Program make_program(bool shared_memory) {
  constexpr unsigned kExecutable = 4;  // PROT_EXEC
  const auto self = static_cast<unsigned>(::getpid());
  Program program;
  load(program, field(offsetof(seccomp_data, arch)));
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0));
  answer(program, SECCOMP_RET_KILL_PROCESS);
  load(program, field(offsetof(seccomp_data, nr)));
  for (const unsigned number : kFatal) answer_if(program, number, SECCOMP_RET_KILL_PROCESS);
  // glibc falls back to clone() without clone3(), whose flags a filter cannot read.
  answer_if(program, SYS_clone3, SECCOMP_RET_ERRNO | ENOSYS);
  for (const unsigned number : kAllowed) answer_if(program, number, SECCOMP_RET_ALLOW);
  if (shared_memory) {
    for (const unsigned number : kAllowedOnFiles) answer_if(program, number, SECCOMP_RET_ALLOW);
  }
  allow_bits(program, SYS_clone, 0, CLONE_THREAD, true);
  allow_bits(program, SYS_mmap, 2, kExecutable, false);
  allow_bits(program, SYS_mprotect, 2, kExecutable, false);
  allow_values(program, SYS_socket, 0, std::array<unsigned, 2>{AF_INET, AF_NETLINK});
  // For sockets; and for a log that may be a terminal, where TIOCSTI would inject input.
  allow_values(
      program, SYS_ioctl, 1,
      std::array<unsigned, 7>{TCGETS, FIONBIO, FIONREAD, SIOCGIFCONF, SIOCGIFFLAGS, SIOCGIFADDR, SIOCGIFINDEX});
  allow_values(program, SYS_prlimit64, 0, std::array{0U});  // only its own limits
  allow_values(program, SYS_tgkill, 0, std::array{self});
  allow_values(program, SYS_kill, 0, std::array{self});
  answer(program, kDeny);
  return program;
}

}  // namespace

std::string filter_system_calls(bool shared_memory) {
  if (kSanitized) return {};
  auto instructions = make_program(shared_memory);
  const sock_fprog program{static_cast<unsigned short>(instructions.size()), instructions.data()};
  // For all threads, because the threads of Fast DDS are already running.
  const long done = ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program);
  if (done != 0) return std::string{"system calls cannot be filtered: "} + std::strerror(errno);
  return {};
}

}  // namespace driveline::bridge
