#include "realtime_setup.hpp"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace driveline::rt::setup {

namespace {

constexpr const char* kNotRequested = "not requested";
constexpr const char* kGrantCapabilities =
    "run as root, or `setcap cap_sys_nice,cap_ipc_lock,cap_net_raw+ep build/driveline`";

RealtimeItem item_of(const char* name, std::string requested) {
  return {.name = name, .requested = std::move(requested), .effective = {}, .remedy = {}};
}

std::string kib(std::uint64_t value) {
  return std::to_string(value) + " KiB";
}

/// A number in /proc/self/status, such as "VmLck:"; 0 if it is missing.
std::uint64_t status_value(const std::string& key, int base = 10) {
  std::ifstream status{"/proc/self/status"};
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, key.size(), key) == 0) {
      return std::strtoull(line.c_str() + key.size(), nullptr, base);
    }
  }
  return 0;
}

// A limit that leaves less room than this above the memory mapped now is treated as a refusal: memory that is mapped
// later also counts, and the next thread stack or heap extension would fail in the middle of the run.
constexpr std::uint64_t kLockHeadroomKib = 64 * 1024;

/// The limit on locked memory if it is too tight for this process.
std::optional<std::uint64_t> tight_memlock_limit_kib() {
  constexpr unsigned kCapIpcLock = 14;  // linux/capability.h
  rlimit limit{};
  if (((status_value("CapEff:", 16) >> kCapIpcLock) & 1U) != 0 || getrlimit(RLIMIT_MEMLOCK, &limit) != 0 ||
      limit.rlim_cur == RLIM_INFINITY) {
    return std::nullopt;
  }
  const std::uint64_t limit_kib = limit.rlim_cur / 1024;
  return limit_kib < status_value("VmSize:") + kLockHeadroomKib ? std::optional{limit_kib} : std::nullopt;
}

std::string cpu_list(const cpu_set_t& set) {
  std::string text;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &set)) {
      continue;
    }
    int last = cpu;
    while (last + 1 < CPU_SETSIZE && CPU_ISSET(last + 1, &set)) {
      ++last;
    }
    text.append(text.empty() ? "" : ",").append(std::to_string(cpu));
    if (last > cpu) {
      text.append("-").append(std::to_string(last));
    }
    cpu = last;
  }
  return text;
}

std::string scheduler_text(int policy, int priority) {
  switch (policy) {
    case SCHED_FIFO:
      return "SCHED_FIFO " + std::to_string(priority);
    case SCHED_RR:
      return "SCHED_RR " + std::to_string(priority);
    case SCHED_OTHER:
      return "SCHED_OTHER";
    default:
      return "scheduling policy " + std::to_string(policy);
  }
}

std::string scheduler_remedy(int error_number, int priority) {
  if (error_number == EINVAL) {
    return "choose a priority from " + std::to_string(sched_get_priority_min(SCHED_FIFO)) + " to " +
           std::to_string(sched_get_priority_max(SCHED_FIFO));
  }
  if (geteuid() == 0) {
    return "give the container CAP_SYS_NICE, and its cgroup a real-time budget (cpu.rt_runtime_us) if it has one";
  }
  return std::string{kGrantCapabilities} + ", or allow the priority with `ulimit -r " + std::to_string(priority) +
         "` (rtprio in /etc/security/limits.conf)";
}

}  // namespace

RealtimeItem lock_memory(bool requested) {
  RealtimeItem item = item_of("memory lock", requested ? "all memory locked" : kNotRequested);
  std::optional<std::uint64_t> tight_limit_kib;
  if (requested) {
    tight_limit_kib = tight_memlock_limit_kib();
    // Lock future mappings only when they are touched (ONFAULT): the cycle's memory is touched beforehand, and the 8
    // MiB stacks of library helper threads need not be resident.
    if (tight_limit_kib) {
      item.error_number = ENOMEM;
    } else if (mlockall(MCL_CURRENT) != 0 || mlockall(MCL_FUTURE | MCL_ONFAULT) != 0) {
      item.error_number = errno;
    }
  }
  const std::uint64_t locked_kib = status_value("VmLck:");
  item.effective = kib(locked_kib) + " of " + kib(status_value("VmSize:")) + " locked";
  item.ok = !requested || (item.error_number == 0 && locked_kib > 0);
  if (!item.ok) {
    item.remedy = tight_limit_kib ? "the limit of " + kib(*tight_limit_kib) + " is too small: " : std::string{};
    item.remedy += geteuid() == 0 ? std::string{"give the container CAP_IPC_LOCK"} : std::string{kGrantCapabilities};
    item.remedy += ", or lift the limit with `ulimit -l unlimited` (memlock in /etc/security/limits.conf)";
  }
  return item;
}

RealtimeItem keep_heap(bool requested) {
  RealtimeItem item = item_of("heap", requested ? "kept in the process" : kNotRequested);
  if (!requested) {
    item.effective = "not changed";
    return item;
  }
  const bool accepted = mallopt(M_TRIM_THRESHOLD, -1) == 1 && mallopt(M_MMAP_MAX, 0) == 1;
  // malloc cannot report its options. Allocating a block far above the default mmap threshold checks the effect of one
  // option: the block must not become a mapping of its own.
  constexpr std::size_t kLargeBlockBytes = 4 * 1024 * 1024;
  const std::size_t mappings = mallinfo2().hblks;
  void* block = std::malloc(kLargeBlockBytes);
  asm volatile("" : : "g"(block) : "memory");  // keeps the compiler from removing the pair
  item.ok = accepted && block != nullptr && mallinfo2().hblks <= mappings;
  std::free(block);
  item.effective = item.ok ? "kept in the process" : "returned to the kernel when freed";
  if (!item.ok) {
    item.remedy = "run with the allocator of glibc (no sanitizer, no preloaded allocator)";
  }
  return item;
}

RealtimeItem prefault_stack() {
  RealtimeItem item = item_of("stack", {});
  pthread_attr_t attributes;
  item.error_number = pthread_getattr_np(pthread_self(), &attributes);
  if (item.error_number != 0) {
    item.requested = "completely resident";
    item.effective = "stack not found";
    item.ok = false;
    item.remedy = "mount /proc and leave memory for the thread";
    return item;
  }
  void* lowest = nullptr;
  std::size_t bytes = 0;
  pthread_attr_getstack(&attributes, &lowest, &bytes);
  pthread_attr_destroy(&attributes);

  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  auto* const first = static_cast<volatile std::uint8_t*>(lowest);
  const std::size_t in_use_from =
      static_cast<std::size_t>(static_cast<volatile std::uint8_t*>(__builtin_frame_address(0)) - first) / page;
  // From the page below this frame downwards, as a stack grows. Writing back each byte as it was read cannot damage
  // anything.
  for (std::size_t i = in_use_from; i-- > 0;) {
    first[i * page] = first[i * page];
  }

  std::vector<unsigned char> residency((bytes + page - 1) / page);
  if (mincore(lowest, bytes, residency.data()) != 0) {
    item.error_number = errno;
  }
  const auto resident = static_cast<std::size_t>(
      std::count_if(residency.begin(), residency.end(), [](unsigned char flags) { return (flags & 1U) != 0; }));
  item.requested = kib(residency.size() * page / 1024) + " resident";
  item.effective = kib(resident * page / 1024) + " resident";
  item.ok = item.error_number == 0 && resident == residency.size();
  if (!item.ok) {
    item.remedy = "leave more memory free, or configure a smaller stack";
  }
  return item;
}

RealtimeItem set_timer_slack(std::chrono::nanoseconds slack) {
  RealtimeItem item = item_of("timer slack", "at most " + std::to_string(slack.count()) + " ns");
  // 0 would select the default of the process, so it is not passed on.
  if (slack.count() < 1) {
    item.error_number = EINVAL;
  } else if (prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack.count()), 0, 0, 0) != 0) {
    item.error_number = errno;
  }
  const int effective_ns = prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0);
  item.effective = std::to_string(effective_ns) + " ns";
  item.ok = item.error_number == 0 && effective_ns >= 0 && effective_ns <= slack.count();
  if (!item.ok) {
    item.remedy = item.error_number == EINVAL
                      ? "configure at least 1 ns"
                      : "allow prctl(PR_SET_TIMERSLACK) in the seccomp profile of the container";
  }
  return item;
}

RealtimeItem pin_to_cpu(std::optional<int> cpu) {
  RealtimeItem item = item_of("CPU", cpu ? std::to_string(*cpu) : kNotRequested);
  cpu_set_t wanted;
  CPU_ZERO(&wanted);
  if (cpu && *cpu >= 0 && *cpu < CPU_SETSIZE) {
    CPU_SET(*cpu, &wanted);
  }
  if (cpu) {
    item.error_number = pthread_setaffinity_np(pthread_self(), sizeof wanted, &wanted);
  }
  cpu_set_t effective;
  CPU_ZERO(&effective);
  const int read_error = pthread_getaffinity_np(pthread_self(), sizeof effective, &effective);
  item.error_number = item.error_number != 0 ? item.error_number : read_error;
  item.effective = cpu_list(effective);
  item.ok = !cpu || (item.error_number == 0 && CPU_EQUAL(&wanted, &effective));
  if (!item.ok) {
    item.remedy = "choose one of the CPUs this process may use (" + item.effective +
                  "), or widen them (taskset, cpuset of the container)";
  }
  return item;
}

RealtimeItem set_scheduler(std::optional<int> priority) {
  RealtimeItem item = item_of("scheduler", priority ? scheduler_text(SCHED_FIFO, *priority) : kNotRequested);
  if (priority) {
    sched_param wanted{};
    wanted.sched_priority = *priority;
    item.error_number = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  }
  int policy = -1;
  sched_param effective{};
  const int read_error = pthread_getschedparam(pthread_self(), &policy, &effective);
  item.error_number = item.error_number != 0 ? item.error_number : read_error;
  item.effective = scheduler_text(policy, effective.sched_priority);
  item.ok = !priority || item.effective == item.requested;
  if (!item.ok) {
    item.remedy = scheduler_remedy(item.error_number, *priority);
  }
  return item;
}

RealtimeItem no_thread(int error_number) {
  RealtimeItem item = item_of("thread", "created");
  item.effective = "not created";
  item.ok = false;
  item.error_number = error_number;
  item.remedy = "leave memory for its stack and raise the number of threads (`ulimit -u`, pids limit of the container)";
  return item;
}

}  // namespace driveline::rt::setup
