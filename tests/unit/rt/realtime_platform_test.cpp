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

TEST(RealtimePlatform, ThisMachineHasAVersionAndFourItems) {
  const PlatformSource source = PlatformSource::this_machine();
  EXPECT_THAT(source.uname_version, testing::StartsWith("#"));
  EXPECT_EQ(inspect_platform(source, std::nullopt).size(), 4u);
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
