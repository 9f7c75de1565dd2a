#include "driveline/rt/realtime_platform.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace driveline::rt {
namespace {

using testing::HasSubstr;

/// A made-up /proc and /sys.
class RealtimePlatformTest : public testing::Test {
 protected:
  RealtimePlatformTest() {
    std::string pattern = testing::TempDir() + "driveline-platform-XXXXXX";
    const char* const made = mkdtemp(pattern.data());
    root_ = made == nullptr ? "" : made;
  }
  ~RealtimePlatformTest() override {
    if (!root_.empty()) {
      std::filesystem::remove_all(root_);
    }
  }

  void write(const std::string& path, const std::string& text) const {
    const std::filesystem::path file = root_ + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream{file} << text << "\n";
  }

  [[nodiscard]] RealtimeItem item(const std::string& name, std::optional<int> cpu = 1,
                                  const std::string& version = "#1 SMP") const {
    for (RealtimeItem& found : inspect_platform({.root = root_, .uname_version = version}, cpu)) {
      if (found.name == name) {
        return std::move(found);
      }
    }
    ADD_FAILURE() << "no item " << name;
    return {};
  }

  /// A thread as proc(5) describes it.
  void thread(int process, int id, const std::string& name, unsigned flags, int priority, int policy,
              const std::string& cpus) const {
    const auto folder = "/proc/" + std::to_string(process) + "/task/" + std::to_string(id);
    std::string stat = std::to_string(id) + " (" + name + ") S 1 1 1 0 -1 " + std::to_string(flags);
    for (int field = 10; field < 40; ++field) stat += " 0";
    write(folder + "/stat", stat + " " + std::to_string(priority) + " " + std::to_string(policy) + " 0");
    write(folder + "/status", "Name:\t" + name + "\nCpus_allowed_list:\t" + cpus);
  }

 private:
  std::string root_;
};

TEST_F(RealtimePlatformTest, PreemptionModelComesFromTheVersion) {
  const auto model = [this](const std::string& version) { return item("kernel preemption", 1, version).effective; };
  EXPECT_EQ(model("#1 SMP PREEMPT_RT Debian 6.1.76-1 (2024-02-01)"), "PREEMPT_RT");
  EXPECT_EQ(model("#1 SMP PREEMPT_DYNAMIC Debian 6.1.76-1"), "PREEMPT_DYNAMIC");
  EXPECT_EQ(model("#1 SMP PREEMPT Thu Jan 1"), "PREEMPT");
  EXPECT_EQ(model("#1 SMP Debian 5.10.0"), "no preemption in the kernel");
  EXPECT_FALSE(item("kernel preemption", 1, "#1 SMP PREEMPT_DYNAMIC").ok);
  EXPECT_THAT(item("kernel preemption", 1, "#1 SMP PREEMPT").remedy, HasSubstr("PREEMPT_RT"));
  EXPECT_TRUE(item("kernel preemption", 1, "#1 SMP PREEMPT_RT").ok);
}

TEST_F(RealtimePlatformTest, PatchedKernelSaysSoInSys) {
  write("/sys/kernel/realtime", "1");
  EXPECT_EQ(item("kernel preemption", 1, "#1 SMP PREEMPT").effective, "PREEMPT_RT");
  write("/sys/kernel/realtime", "0");
  EXPECT_EQ(item("kernel preemption", 1, "#1 SMP PREEMPT").effective, "PREEMPT");
}

TEST_F(RealtimePlatformTest, OtherRealtimeThreadsOnTheCpuAreNamed) {
  EXPECT_EQ(item("neighbours").effective, "none");
  thread(20, 20, "migration/1", 0x0420'8040, 99, 1, "1");
  thread(100, 100, "driveline", 0x0040'0000, 0, 0, "1");
  thread(100, 102, "elsewhere", 0x0040'0000, 80, 1, "0");
  thread(100, 103, "anywhere", 0x0040'0000, 80, 1, "0-1");
  EXPECT_TRUE(item("neighbours").ok) << item("neighbours").effective;
  thread(100, 101, "a ) \x1B[2J", 0x0040'0000, 80, 1, "1");
  thread(200, 200, "jackd", 0x0040'0000, 10, 2, "1");
  const auto found = item("neighbours");
  EXPECT_FALSE(found.ok);
  EXPECT_THAT(found.effective, HasSubstr("a ) ?[2J (process 100, priority 80)"));
  EXPECT_THAT(found.effective, HasSubstr("jackd (process 200, priority 10)"));
  EXPECT_THAT(found.remedy, HasSubstr("a CPU of its own"));
  EXPECT_TRUE(item("neighbours", std::nullopt).ok) << "without a CPU the kernel finds one";
}

/// Threads that the master pins itself are intended.
TEST_F(RealtimePlatformTest, ThreadsOfThisProcessAreNoNeighbours) {
  thread(getpid(), getpid(), "cycle", 0x0040'0000, 80, 1, "1");
  EXPECT_TRUE(item("neighbours").ok) << item("neighbours").effective;
}

TEST(AllowedCpu, BesidesAnotherIsNotThatOne) {
  EXPECT_NE(allowed_cpu_besides(0), 0);
  EXPECT_TRUE(allowed_cpu_besides(-1)) << "there is at least one";
}

TEST_F(RealtimePlatformTest, ThrottlingIsReportedWithItsNumbers) {
  EXPECT_THAT(item("real-time throttling").effective, HasSubstr("unknown"));
  write("/proc/sys/kernel/sched_rt_runtime_us", "950000");
  write("/proc/sys/kernel/sched_rt_period_us", "1000000");
  EXPECT_FALSE(item("real-time throttling").ok);
  EXPECT_EQ(item("real-time throttling").effective, "possible after 950000 us of CPU time in every 1000000 us");
  write("/proc/sys/kernel/sched_rt_runtime_us", "-1");
  EXPECT_TRUE(item("real-time throttling").ok);
  EXPECT_EQ(item("real-time throttling").effective, "off");
}

TEST_F(RealtimePlatformTest, IsolationIsJudgedForTheCpuOfTheThread) {
  write("/sys/devices/system/cpu/isolated", "");
  EXPECT_EQ(item("CPU isolation").effective, "no CPU isolated");
  EXPECT_THAT(item("CPU isolation").remedy, HasSubstr("isolcpus=1"));
  write("/sys/devices/system/cpu/isolated", "1,3-5");
  EXPECT_TRUE(item("CPU isolation", 1).ok);
  EXPECT_TRUE(item("CPU isolation", 4).ok);
  EXPECT_FALSE(item("CPU isolation", 2).ok);
  EXPECT_FALSE(item("CPU isolation", std::nullopt).ok);
}

TEST_F(RealtimePlatformTest, GovernorIsThatOfTheCpuIfThereIsOne) {
  EXPECT_EQ(item("frequency governor").effective, "none");
  EXPECT_TRUE(item("frequency governor").ok);
  write("/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave");
  EXPECT_FALSE(item("frequency governor").ok);
  EXPECT_EQ(item("frequency governor").effective, "powersave");
  EXPECT_TRUE(item("frequency governor", 0).ok);
  write("/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance");
  EXPECT_TRUE(item("frequency governor").ok);
}

TEST(RealtimePlatform, ThisMachineHasAVersionAndFiveItems) {
  const PlatformSource source = PlatformSource::this_machine();
  EXPECT_THAT(source.uname_version, testing::StartsWith("#"));
  EXPECT_EQ(inspect_platform(source, std::nullopt).size(), 5u);
}

TEST(CpuList, FindsSinglesAndRanges) {
  EXPECT_TRUE(cpu_list_contains("0", 0));
  EXPECT_TRUE(cpu_list_contains("0-3,8,10-11", 3));
  EXPECT_TRUE(cpu_list_contains("0-3,8,10-11", 8));
  EXPECT_TRUE(cpu_list_contains("0-3,8,10-11", 11));
  EXPECT_FALSE(cpu_list_contains("0-3,8,10-11", 4));
  EXPECT_FALSE(cpu_list_contains("0-3,8,10-11", 12));
  EXPECT_FALSE(cpu_list_contains("10", 1));
}

TEST(CpuList, NonsenseContainsNothing) {
  for (const char* list : {"", ",", "-", "x", "0-", "0-x", "1;2"}) {
    EXPECT_FALSE(cpu_list_contains(list, 2)) << list;
  }
}

}  // namespace
}  // namespace driveline::rt
