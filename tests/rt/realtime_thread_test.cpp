#include "driveline/rt/realtime_thread.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "driveline/rt/clock.hpp"
#include "rt_support.hpp"

namespace driveline::rt {

namespace test {

std::string realtime_refusal() {
  const pid_t child = fork();
  if (child == 0) {
    sched_param parameters{};
    parameters.sched_priority = 80;
    if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
      _exit(1);
    }
    _exit(mlockall(MCL_CURRENT | MCL_FUTURE) != 0 ? 2 : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (kSanitized) {
    return "a sanitizer turns mlockall off in this build";
  }
  switch (WIFEXITED(status) ? WEXITSTATUS(status) : -1) {
    case 0:
      return "";
    case 1:
      return "the kernel refuses SCHED_FIFO here";
    default:
      return "the kernel refuses mlockall here";
  }
}

const RealtimeItem& setting(const RealtimeReport& report, const std::string& name) {
  for (const RealtimeItem& item : report.settings) {
    if (item.name == name) {
      return item;
    }
  }
  throw std::out_of_range("the report has no setting " + name + ":\n" + text_of(report));
}

std::string text_of(const RealtimeReport& report) {
  std::string text;
  for (const std::string& line : to_lines(report)) {
    text += line + "\n";
  }
  return text;
}

}  // namespace test

namespace {

using test::setting;
using test::text_of;
using testing::HasSubstr;

/// Properties of the thread, read by other means than in the code under test.
struct SelfPortrait : RealtimeTask {
  std::string stat;  // fields of /proc/thread-self/stat after the name
  std::string name;
  int on_cpu = -1;
  int allowed_cpus = 0;
  int timer_slack_ns = -1;
  bool sigterm_blocked = false;
  long faults_on_deep_stack = -1;

  void run(std::stop_token) noexcept override {
    std::ifstream{"/proc/thread-self/comm"} >> name;
    std::getline(std::ifstream{"/proc/thread-self/stat"}, stat);
    stat.erase(0, stat.rfind(')') + 2);
    on_cpu = sched_getcpu();
    cpu_set_t set;
    CPU_ZERO(&set);
    sched_getaffinity(0, sizeof set, &set);
    allowed_cpus = CPU_COUNT(&set);
    timer_slack_ns = prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0);
    sigset_t mask;
    pthread_sigmask(SIG_SETMASK, nullptr, &mask);
    sigterm_blocked = sigismember(&mask, SIGTERM) == 1;
    if (!test::kSanitized) {  // a sanitizer stores large data of its own at the top of every stack
      const long before = faults();
      use_stack();
      faults_on_deep_stack = faults() - before;
    }
  }

  /// Field of proc(5), "stat", counted from 1 as in that page.
  [[nodiscard]] int stat_field(int number) const {
    std::istringstream fields{stat};
    std::string field;
    for (int i = 3; i <= number; ++i) {  // the first two were cut off
      fields >> field;
    }
    return std::stoi(field);
  }

  static long faults() noexcept {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_minflt + usage.ru_majflt;
  }

  [[gnu::noinline]] static void use_stack() noexcept {
    unsigned char room[400 * 1024];
    std::memset(room, 1, sizeof room);
    asm volatile("" : : "r"(&room[0]) : "memory");
  }
};

int last_allowed_cpu() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  int last = 0;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    last = CPU_ISSET(cpu, &set) ? cpu : last;
  }
  return last;
}

std::uint64_t vm_locked_kib() {
  std::ifstream status{"/proc/self/status"};
  for (std::string word; status >> word;) {
    if (word == "VmLck:") {
      std::uint64_t value = 0;
      status >> value;
      return value;
    }
  }
  return 0;
}

/// A configuration that needs no privileges.
RealtimeConfig modest() {
  RealtimeConfig config;
  config.priority.reset();
  config.lock_memory = false;
  return config;
}

class PrivilegedRealtimeThreadTest : public testing::Test {
 protected:
  void SetUp() override {
    const std::string refusal = test::realtime_refusal();
    if (!refusal.empty()) {
      GTEST_SKIP() << refusal;
    }
  }
  void TearDown() override { munlockall(); }
};

/// Two threads of equal priority on one CPU: each spins until the other has done its part.
struct OneCpuForTwo {
  std::atomic<bool> other_ready = false;
  std::atomic<bool> waits = false;
  std::atomic<bool> done = false;
};

class WaitsBusily final : public RealtimeTask {
 public:
  explicit WaitsBusily(OneCpuForTwo& both) : both_(both) {}
  void run(std::stop_token) noexcept override {
    MonotonicClock clock;
    while (!both_.other_ready) clock.sleep_until(clock.now() + std::chrono::milliseconds{1});
    // The other one is runnable at the deadline at the latest, also where the machine stood still until then.
    const auto deadline = clock.now() + std::chrono::milliseconds{500};
    both_.waits = true;
    for (int turns = 0; !both_.done && turns < kTurnsAfterDeadline;) {
      clock.yield();
      if (clock.now() >= deadline) ++turns;
    }
    saw = both_.done.load();
  }
  bool saw = false;

 private:
  static constexpr int kTurnsAfterDeadline = 1000;

  OneCpuForTwo& both_;
};

class ActsInBetween final : public RealtimeTask {
 public:
  explicit ActsInBetween(OneCpuForTwo& both) : both_(both) {}
  void run(std::stop_token) noexcept override {
    MonotonicClock clock;
    both_.other_ready = true;
    while (!both_.waits) clock.sleep_until(clock.now() + std::chrono::milliseconds{1});
    both_.done = true;
  }

 private:
  OneCpuForTwo& both_;
};

TEST_F(PrivilegedRealtimeThreadTest, AThreadThatGivesWayLetsOthersOfItsPriorityRun) {
  RealtimeConfig config;
  config.priority = 73;
  config.cpu = last_allowed_cpu();
  OneCpuForTwo both;
  WaitsBusily waiting(both);
  ActsInBetween acting(both);
  RealtimeThread first;
  RealtimeThread second;
  ASSERT_TRUE(first.start(config, waiting).has_value());
  ASSERT_TRUE(second.start(config, acting).has_value());
  first.join();
  second.join();
  EXPECT_TRUE(waiting.saw);
}

TEST_F(PrivilegedRealtimeThreadTest, EverythingRequestedIsInEffect) {
  RealtimeConfig config;
  config.priority = 73;
  config.cpu = last_allowed_cpu();
  config.name = "a-name-that-is-too-long";
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  thread.join();

  constexpr int kPriorityField = 40;
  constexpr int kPolicyField = 41;
  EXPECT_EQ(task.stat_field(kPolicyField), SCHED_FIFO);
  EXPECT_EQ(task.stat_field(kPriorityField), 73);
  EXPECT_EQ(task.name, "a-name-that-is-");
  EXPECT_EQ(task.on_cpu, *config.cpu);
  EXPECT_EQ(task.allowed_cpus, 1);
  EXPECT_LE(task.timer_slack_ns, 1);
  EXPECT_GT(vm_locked_kib(), 0u);
  EXPECT_TRUE(task.sigterm_blocked);

  EXPECT_TRUE(report->complete()) << text_of(*report);
  EXPECT_EQ(setting(*report, "scheduler").effective, "SCHED_FIFO 73");
  EXPECT_EQ(setting(*report, "CPU").effective, std::to_string(*config.cpu));
  EXPECT_EQ(setting(*report, "stack").effective, "512 KiB resident");
  EXPECT_EQ(setting(*report, "heap").effective, "kept in the process");
  EXPECT_THAT(setting(*report, "memory lock").effective, testing::Not(testing::StartsWith("0 KiB")));
  EXPECT_EQ(setting(*report, "timer slack").effective, std::to_string(task.timer_slack_ns) + " ns");
  EXPECT_EQ(report->platform.size(), 14u);
}

TEST_F(PrivilegedRealtimeThreadTest, ASecondOneOnTheSameCpuIsToldWhoIsThere) {
  int ready[2] = {-1, -1};
  ASSERT_EQ(pipe(ready), 0);
  const int cpu = last_allowed_cpu();
  const pid_t child = fork();
  if (child == 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(cpu, &set);
    sched_param parameters{};
    parameters.sched_priority = 7;
    const char pinned =
        sched_setaffinity(0, sizeof set, &set) == 0 && sched_setscheduler(0, SCHED_FIFO, &parameters) == 0 ? 'y' : 'n';
    if (write(ready[1], &pinned, 1) == 1) pause();
    _exit(0);
  }
  char pinned = 0;
  EXPECT_EQ(read(ready[0], &pinned, 1), 1);
  EXPECT_EQ(pinned, 'y');
  RealtimeConfig config;
  config.cpu = cpu;
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  thread.join();
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ready[0]);
  close(ready[1]);
  ASSERT_TRUE(report.has_value()) << "it is a note: " << report.error().message();
  EXPECT_THAT(text_of(*report), HasSubstr(" (process " + std::to_string(child) +
                                          ", priority 7) instead of no other real-time thread on CPU " +
                                          std::to_string(cpu) + "; remedy: give each a CPU of its own"));
}

TEST_F(PrivilegedRealtimeThreadTest, DeepUseOfTheStackFaultsNoPageIn) {
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(RealtimeConfig{}, task);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  thread.join();
  EXPECT_EQ(task.faults_on_deep_stack, 0);
}

TEST(RealtimeThread, WithoutRequestsTheTaskRunsAsAnOrdinaryThread) {
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(modest(), task);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  thread.join();
  EXPECT_EQ(task.stat_field(41), SCHED_OTHER);
  EXPECT_EQ(setting(*report, "scheduler").requested, "not requested");
  EXPECT_EQ(setting(*report, "scheduler").effective, "SCHED_OTHER");
  EXPECT_EQ(setting(*report, "memory lock").requested, "not requested");
}

TEST(RealtimeThread, ImpossibleCpuIsRefusedWithTheCpusThereAre) {
  RealtimeConfig config = modest();
  for (const int cpu : {CPU_SETSIZE - 1, CPU_SETSIZE, -1}) {
    config.cpu = cpu;
    SelfPortrait task;
    RealtimeThread thread;
    const auto report = thread.start(config, task);
    ASSERT_FALSE(report.has_value());
    EXPECT_EQ(task.on_cpu, -1) << "the task must not run";
    EXPECT_EQ(setting(report.error().report, "CPU").error_number, EINVAL);
    EXPECT_THAT(report.error().message(), HasSubstr("CPU is "));
    EXPECT_THAT(report.error().message(), HasSubstr("instead of " + std::to_string(cpu)));
    EXPECT_THAT(report.error().message(), HasSubstr("choose one of the CPUs this process may use"));
  }
}

TEST(RealtimeThread, ImpossiblePriorityIsRefusedWithTheRange) {
  RealtimeConfig config = modest();
  config.priority = 100;
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(setting(report.error().report, "scheduler").error_number, EINVAL);
  EXPECT_THAT(report.error().message(),
              HasSubstr("scheduler is SCHED_OTHER instead of SCHED_FIFO 100 (Invalid argument)"));
  EXPECT_THAT(report.error().message(), HasSubstr("choose a priority from 1 to 99"));
}

TEST(RealtimeThread, TimerSlackOfZeroIsRefusedBecauseItWouldMeanTheDefault) {
  RealtimeConfig config = modest();
  config.timer_slack = std::chrono::nanoseconds::zero();
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  ASSERT_FALSE(report.has_value());
  EXPECT_FALSE(setting(report.error().report, "timer slack").ok);
}

TEST(RealtimeThread, StartWorksAfterARefusedStart) {
  RealtimeConfig config = modest();
  config.cpu = -1;
  SelfPortrait task;
  RealtimeThread thread;
  ASSERT_FALSE(thread.start(config, task).has_value());
  config.cpu = last_allowed_cpu();
  ASSERT_TRUE(thread.start(config, task).has_value());
  thread.join();
  EXPECT_EQ(task.on_cpu, *config.cpu);
}

TEST(RealtimeThread, StackNobodyCanHaveIsAnErrorUnderEitherPolicy) {
  RealtimeConfig config = modest();
  config.policy = RealtimePolicy::kDegrade;
  config.stack_bytes = std::size_t{1} << 50U;
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  ASSERT_FALSE(report.has_value());
  EXPECT_NE(setting(report.error().report, "thread").error_number, 0);
  EXPECT_THAT(report.error().message(), HasSubstr("thread is not created"));
}

struct UntilStopped : RealtimeTask {
  std::atomic<int> turns{0};
  std::atomic<bool> ended{false};
  void run(std::stop_token stop) noexcept override {
    while (!stop.stop_requested()) {
      turns.fetch_add(1);
      std::this_thread::yield();
    }
    ended.store(true);
  }
};

/// Number of open descriptors of this process that refer to `file`.
int descriptors_of(const std::filesystem::path& file) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;  // for the descriptor of this iteration
    found += std::filesystem::read_symlink(entry, gone) == file ? 1 : 0;
  }
  return found;
}

const RealtimeItem& latency_item(const RealtimeReport& report) {
  return report.cpu_latency;
}

TEST(RealtimeThread, IdleCpusAreKeptAwakeUntilTheThreadHasBeenJoined) {
  const auto device = std::filesystem::path(testing::TempDir()) / ("latency-" + std::to_string(getpid()));
  std::ofstream{device}.close();
  RealtimeConfig config = modest();
  config.cpu_latency = std::chrono::microseconds{7};
  config.cpu_latency_device = device;
  for (const bool refused : {false, true}) {
    config.cpu = refused ? std::optional(-1) : std::nullopt;
    UntilStopped task;
    RealtimeThread thread;
    const auto report = thread.start(config, task);
    ASSERT_EQ(report.has_value(), !refused);
    EXPECT_EQ(descriptors_of(device), refused ? 0 : 1) << "the request lives as long as the file is open";
    const auto& item = latency_item(refused ? report.error().report : *report);
    EXPECT_TRUE(item.ok);
    EXPECT_EQ(item.requested, "at most 7 us");
    EXPECT_EQ(item.effective, "at most 7 us");
    thread.request_stop();
    thread.join();
    EXPECT_EQ(descriptors_of(device), 0);
  }
  std::int32_t written_us = -1;
  std::ifstream file(device, std::ios::binary);
  file.read(reinterpret_cast<char*>(&written_us), sizeof written_us);
  EXPECT_EQ(written_us, 7);
  std::filesystem::remove(device);
}

TEST(RealtimeThread, ALatencyDeviceThatCannotBeOpenedIsANoteAndNoRefusal) {
  RealtimeConfig config = modest();
  config.cpu_latency_device = "/nowhere/cpu_dma_latency";
  SelfPortrait task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  thread.join();
  EXPECT_NE(task.on_cpu, -1) << "the task has run";
  const auto& item = latency_item(*report);
  EXPECT_FALSE(item.ok);
  EXPECT_EQ(item.error_number, ENOENT);
  EXPECT_TRUE(report->complete());
  EXPECT_THAT(text_of(*report),
              testing::ContainsRegex("CPU wake-up time +note +left to the kernel instead of at most 0 "
                                     "us \\(No such file or directory\\); remedy: none where"));
}

TEST(RealtimeThread, CpusMaySleepWhenNobodyAsksOtherwise) {
  RealtimeConfig config = modest();
  config.cpu_latency.reset();
  UntilStopped task;
  RealtimeThread thread;
  const auto report = thread.start(config, task);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  EXPECT_EQ(descriptors_of(CpuLatencyHold::kDevice), 0);
  EXPECT_TRUE(latency_item(*report).ok);
  EXPECT_EQ(latency_item(*report).requested, "not requested");
}

// The limit that the kernel's device returns to a process without a request.
TEST(RealtimeThread, TheKernelKnowsOfTheRequest) {
  const int device = open(CpuLatencyHold::kDevice, O_RDONLY | O_CLOEXEC);
  if (device < 0) GTEST_SKIP() << CpuLatencyHold::kDevice << ": " << std::strerror(errno);
  UntilStopped task;
  RealtimeThread thread;
  const auto report = thread.start(modest(), task);
  ASSERT_TRUE(report.has_value()) << report.error().message();
  EXPECT_EQ(latency_item(*report).effective, "at most 0 us");
  std::int32_t effective_us = -1;
  EXPECT_EQ(read(device, &effective_us, sizeof effective_us), static_cast<ssize_t>(sizeof effective_us));
  EXPECT_EQ(effective_us, 0);
  close(device);
}

TEST(RealtimeThread, DestructionStopsAndJoins) {
  UntilStopped task;
  {
    RealtimeThread thread;
    ASSERT_TRUE(thread.start(modest(), task).has_value());
    while (task.turns.load() == 0) {
      std::this_thread::yield();
    }
    EXPECT_FALSE(task.ended.load());
  }
  EXPECT_TRUE(task.ended.load());
}

/// Ignores the stop request until it is released.
struct Deaf : RealtimeTask {
  std::promise<void> release;
  void run(std::stop_token) noexcept override { release.get_future().wait(); }
};

TEST(RealtimeThread, ATaskThatDoesNotEndIsNotWaitedForWithoutEnd) {
  Deaf task;
  RealtimeThread thread;
  ASSERT_TRUE(thread.start(modest(), task).has_value());
  thread.request_stop();
  EXPECT_FALSE(thread.join_for(std::chrono::milliseconds{10}));
  EXPECT_FALSE(thread.join_for(std::chrono::nanoseconds{0}));
  task.release.set_value();
  EXPECT_TRUE(thread.join_for(std::chrono::hours{1}));
  EXPECT_TRUE(thread.join_for(std::chrono::nanoseconds{0})) << "there is none any more";
}

TEST(RealtimeThread, SecondStartWithoutJoinIsAProgrammingError) {
  UntilStopped task;
  RealtimeThread thread;
  ASSERT_TRUE(thread.start(modest(), task).has_value());
  EXPECT_THROW((void)thread.start(modest(), task), std::logic_error);
  thread.request_stop();
  thread.join();
  EXPECT_TRUE(task.ended.load());
}

TEST(RealtimeThread, StopAndJoinWithoutAThreadDoNothing) {
  RealtimeThread thread;
  thread.request_stop();
  thread.join();
}

}  // namespace
}  // namespace driveline::rt
