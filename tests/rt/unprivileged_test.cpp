#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <string>

#include "driveline/rt/realtime_thread.hpp"
#include "rt_support.hpp"

/// The real-time set-up for an ordinary user. Each case runs in a child process that has dropped its privileges and
/// returns a text.
namespace driveline::rt {
namespace {

using testing::HasSubstr;

constexpr const char* kNotPossible = "not possible";

/// Drops root, capabilities and the corresponding limits; leaves `memlock_bytes` of lockable memory.
/// @return whether the kernel now refuses what it should refuse.
bool drop_privileges(rlim_t memlock_bytes) {
  constexpr unsigned kNobody = 65534;
  const rlimit none{0, 0};
  const rlimit memory{memlock_bytes, memlock_bytes};
  if (setrlimit(RLIMIT_RTPRIO, &none) != 0 || setrlimit(RLIMIT_MEMLOCK, &memory) != 0) {
    return false;
  }
  if (geteuid() == 0 && (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0)) {
    return false;
  }
  prctl(PR_SET_DUMPABLE, 1, 0, 0, 0);  // a change of user makes /proc/self belong to root
  sched_param parameters{};
  parameters.sched_priority = 1;
  return sched_setscheduler(0, SCHED_FIFO, &parameters) != 0;
}

/// Runs `body` (which returns a text) without privileges and returns its text.
template <typename Body>
std::string as_nobody(rlim_t memlock_bytes, Body body) {
  int channel[2] = {-1, -1};
  if (pipe(channel) != 0) {
    return "no pipe";
  }
  const pid_t child = fork();
  if (child == 0) {
    const std::string text = drop_privileges(memlock_bytes) ? body() : kNotPossible;
    const auto written = write(channel[1], text.data(), text.size());
    _exit(written == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  close(channel[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t bytes = 0; (bytes = read(channel[0], buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(bytes));
  }
  close(channel[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? text : "the child failed after: " + text;
}

struct Witness : RealtimeTask {
  std::atomic<int> policy{-1};
  void run(std::stop_token) noexcept override { policy = sched_getscheduler(0); }
};

/// Starts a thread with the whole set-up and describes the result.
std::string attempt(RealtimePolicy policy) {
  RealtimeConfig config;
  config.policy = policy;
  Witness task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  thread.join();
  std::string text = report.has_value() ? "started\n" + test::text_of(*report) : "refused\n" + report.error().message();
  return text + "\npolicy seen by the task: " + std::to_string(task.policy.load());
}

constexpr rlim_t kUsualLimit = rlim_t{8} * 1024 * 1024;

#define SKIP_IF_NOT_POSSIBLE(text)                                                                          \
  if ((text) == kNotPossible) {                                                                             \
    GTEST_SKIP() << "this process can neither give up real-time scheduling nor set the limits of the case"; \
  }

TEST(UnprivilegedRealtimeThread, EnforceRefusesAndNamesTheRemedy) {
  const std::string text = as_nobody(kUsualLimit, [] { return attempt(RealtimePolicy::kEnforce); });
  SKIP_IF_NOT_POSSIBLE(text);
  EXPECT_THAT(text, testing::StartsWith("refused\nreal-time set-up refused; "));
  EXPECT_THAT(text,
              HasSubstr("scheduler is SCHED_OTHER instead of SCHED_FIFO 80 (Operation not permitted); remedy: run "
                        "as root, or `setcap cap_sys_nice,cap_ipc_lock,cap_net_raw+ep build/driveline`, or allow "
                        "the priority with `ulimit -r 80`"));
  EXPECT_THAT(text, HasSubstr("memory lock is 0 KiB of "));
  EXPECT_THAT(text, HasSubstr("(Cannot allocate memory); remedy: the limit of 8192 KiB is too small"));
  EXPECT_THAT(text, HasSubstr("`ulimit -l unlimited`"));
  EXPECT_THAT(text, HasSubstr("policy seen by the task: -1")) << "the task must not run";
}

TEST(UnprivilegedRealtimeThread, DegradeRunsAndReportsWhatIsMissing) {
  const std::string text = as_nobody(kUsualLimit, [] { return attempt(RealtimePolicy::kDegrade); });
  SKIP_IF_NOT_POSSIBLE(text);
  EXPECT_THAT(text, testing::StartsWith("started\n"));
  EXPECT_THAT(text, testing::ContainsRegex("scheduler +MISSING  SCHED_OTHER instead of SCHED_FIFO 80"));
  EXPECT_THAT(text, testing::ContainsRegex("memory lock +MISSING  0 KiB of "));
  EXPECT_THAT(text, testing::ContainsRegex("stack +ok "));
  EXPECT_THAT(text, testing::ContainsRegex("timer slack +ok +1 ns"));
  EXPECT_THAT(text, HasSubstr("policy seen by the task: " + std::to_string(SCHED_OTHER)));
}

TEST(UnprivilegedRealtimeThread, NoLockableMemoryAtAllIsReportedTheSameWay) {
  const std::string text = as_nobody(0, [] { return attempt(RealtimePolicy::kDegrade); });
  SKIP_IF_NOT_POSSIBLE(text);
  EXPECT_THAT(text, testing::ContainsRegex("memory lock +MISSING  0 KiB of .*limit of 0 KiB is too small"));
}

TEST(UnprivilegedRealtimeThread, SufficientLimitLocksMemoryWithoutCapability) {
  if (test::kSanitized) {
    GTEST_SKIP() << "a sanitizer turns mlockall off in this build";
  }
  const std::string text = as_nobody(rlim_t{4} << 30U, [] { return attempt(RealtimePolicy::kDegrade); });
  SKIP_IF_NOT_POSSIBLE(text);
  EXPECT_THAT(text, testing::ContainsRegex("memory lock +ok +[1-9][0-9]* KiB of "));
}

// The reason for the headroom: with a limit that just fits, the kernel grants the lock but refuses later mappings.
TEST(UnprivilegedRealtimeThread, RefusedLockLeavesMappingsPossible) {
  const std::string text = as_nobody(kUsualLimit, [] {
    attempt(RealtimePolicy::kDegrade);
    void* const mapping = mmap(nullptr, 16 << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return std::string{mapping == MAP_FAILED ? "refused" : "mapped"};
  });
  SKIP_IF_NOT_POSSIBLE(text);
  EXPECT_EQ(text, "mapped");
}

}  // namespace
}  // namespace driveline::rt
