// Context switches reported by the kernel for a processor on which two threads take turns.
#include "driveline/rt/switch_log.hpp"

#include <gmock/gmock.h>
#include <pthread.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>

#include "driveline/rt/clock.hpp"

namespace driveline::rt {
namespace {

using namespace std::chrono_literals;

int some_cpu() {
  return sched_getcpu();
}

void stay_on(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  ASSERT_EQ(pthread_setaffinity_np(pthread_self(), sizeof set, &set), 0);
}

std::int32_t own_number() {
  return static_cast<std::int32_t>(syscall(SYS_gettid));
}

/// Keeps a processor busy in a thread with a name of its own.
class BusyThread {
 public:
  explicit BusyThread(int cpu) : thread_([this, cpu](const std::stop_token& stop) { run(stop, cpu); }) {
    while (number_ == 0) std::this_thread::sleep_for(1ms);
  }
  [[nodiscard]] std::int32_t number() const { return number_; }

 private:
  void run(const std::stop_token& stop, int cpu) {
    stay_on(cpu);
    pthread_setname_np(pthread_self(), "dl-busy");
    number_ = own_number();
    while (!stop.stop_requested()) {
    }
  }
  std::atomic<std::int32_t> number_{0};
  std::jthread thread_;
};

TEST(SwitchLog, NamesTheThreadThatRanWhileThisOneSlept) {
  const int cpu = some_cpu();
  auto log = SwitchLog::open(cpu);
  if (!log) GTEST_SKIP() << log.error().message();
  std::jthread([&] {
    stay_on(cpu);
    const MonotonicClock clock;
    const BusyThread busy(cpu);
    std::array<CpuSwitch, 64> found{};
    std::size_t count = 0;
    const auto before = clock.now();
    // Until the other thread has got its turn, whose time depends on the machine.
    const auto saw_it = [&] {
      return std::any_of(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count),
                         [&](const CpuSwitch& one) { return one.thread == busy.number(); });
    };
    for (int i = 0; i < 1000 && !saw_it(); ++i) {
      std::this_thread::sleep_for(1ms);
      count = (*log)->read(clock.now() - 5ms, found);
    }
    ASSERT_TRUE(saw_it());
    EXPECT_EQ(found[0].thread, own_number()) << "newest first, and that is the one that looks";
    EXPECT_EQ(thread_name(busy.number()), "dl-busy");
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_LE(found[i].time, clock.now());
      EXPECT_LE(found[i].time, found[i == 0 ? 0 : i - 1].time);
      EXPECT_GT(found[i].time, before - 10s);
    }
  }).join();
}

TEST(SwitchLog, KeepsToTheRoomThatThereIs) {
  auto log = SwitchLog::open(some_cpu());
  if (!log) GTEST_SKIP() << log.error().message();
  // More than the log's memory holds.
  for (int i = 0; i < 2000; ++i) std::this_thread::sleep_for(10us);
  std::array<CpuSwitch, 3> few{};
  EXPECT_LE((*log)->read(0ns, few), few.size());
  std::array<CpuSwitch, 4096> all{};
  EXPECT_LE((*log)->read(0ns, all), 2048U);
  EXPECT_EQ((*log)->read(0ns, {}), 0U);
}

TEST(SwitchLog, AProcessorThatDoesNotExistIsRefusedWithASentence) {
  const auto log = SwitchLog::open(4095);
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().message(), testing::HasSubstr("thread switches of CPU 4095 cannot be recorded: "));
}

TEST(SwitchLog, AThreadThatHasEndedHasNoName) {
  EXPECT_EQ(thread_name(0), "idle");
  EXPECT_EQ(thread_name(2'000'000'000), "");
}

}  // namespace
}  // namespace driveline::rt
