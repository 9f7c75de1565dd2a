#include "driveline/rt/realtime_platform.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "support/temporary_directory.hpp"

namespace driveline::rt {
namespace {

using testing::HasSubstr;

/// A simulated /proc and /sys.
class RealtimePlatformTest : public testing::Test {
 protected:
  void write(const std::string& path, const std::string& text) const {
    const std::filesystem::path file = root() + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream{file} << text << "\n";
  }

  [[nodiscard]] RealtimeItem item(const std::string& name, std::optional<int> cpu = 1,
                                  const std::string& version = "#1 SMP") const {
    for (RealtimeItem& found : inspect_platform({.root = root(), .uname_version = version}, cpu)) {
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

  [[nodiscard]] const std::string& root() const { return folder_.path.native(); }

 private:
  test::TemporaryFolder folder_;
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

TEST_F(RealtimePlatformTest, ADynamicKernelSaysWhichModelItUses) {
  const std::string version = "#1 SMP PREEMPT_DYNAMIC";
  write("/proc/cmdline", "quiet preempt=voluntary");
  EXPECT_EQ(item("kernel preemption", 1, version).effective, "PREEMPT_DYNAMIC (voluntary)");
  write("/sys/kernel/debug/sched/preempt", "none voluntary (full)");
  EXPECT_EQ(item("kernel preemption", 1, version).effective, "PREEMPT_DYNAMIC (full)") << "what is in use counts";
}

/// A kernel with RT_GROUP_SCHED gives a new cgroup no real-time budget, and refuses SCHED_FIFO in it.
TEST_F(RealtimePlatformTest, ACgroupWithoutBudgetPreventsRealTime) {
  EXPECT_TRUE(item("real-time group budget").ok) << "no cgroups";
  write("/proc/self/cgroup", "9:name=systemd:/\n2:cpu,cpuacct:/system.slice\n1:cpuset:/other\n0::/");
  EXPECT_TRUE(item("real-time group budget").ok) << "a kernel without group scheduling";
  write("/sys/fs/cgroup/cpu/system.slice/cpu.rt_runtime_us", "0");
  const auto refused = item("real-time group budget");
  EXPECT_FALSE(refused.ok);
  EXPECT_EQ(refused.cost, Cost::kPrevents);
  EXPECT_EQ(refused.effective, "0 us in the cgroup /system.slice");
  EXPECT_THAT(refused.remedy, HasSubstr("/sys/fs/cgroup/cpu/system.slice/cpu.rt_runtime_us"));
  write("/sys/fs/cgroup/cpu/system.slice/cpu.rt_runtime_us", "950000");
  EXPECT_TRUE(item("real-time group budget").ok);
  write("/proc/self/cgroup", "2:cpuset:/x\n1:cpu:/");
  write("/sys/fs/cgroup/cpu/cpu.rt_runtime_us", "950000");
  EXPECT_EQ(item("real-time group budget").effective, "950000 us in the cgroup /");
}

TEST_F(RealtimePlatformTest, ASlowClockSourceIsAFinding) {
  EXPECT_EQ(item("clock source").effective, "unknown");
  const std::string file = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  for (const char* fast : {"tsc", "kvm-clock", "arch_sys_counter"}) {
    write(file, fast);
    EXPECT_TRUE(item("clock source").ok) << fast;
  }
  for (const char* slow : {"hpet", "acpi_pm", "refined-jiffies"}) {
    write(file, slow);
    EXPECT_FALSE(item("clock source").ok) << slow;
    EXPECT_EQ(item("clock source").effective, slow);
  }
}

TEST_F(RealtimePlatformTest, AGuestOfAHypervisorIsTold) {
  write("/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme ht\nmodel name : no hypervisor here");
  EXPECT_TRUE(item("virtual machine").ok);
  write("/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme hypervisor");
  EXPECT_FALSE(item("virtual machine").ok) << "at the end of the line";
  write("/sys/class/dmi/id/sys_vendor", "QEMU");
  EXPECT_EQ(item("virtual machine").effective, "a guest of a hypervisor (QEMU)");
}

/// The first pages that a user reads say the same as `driveline doctor`: what the host costs, and why `run` misses more
/// periods than the program with which users compare it.
TEST_F(RealtimePlatformTest, TheReadmeSaysAboutVirtualMachinesWhatDoctorSays) {
  write("/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme hypervisor");
  const auto said = item("virtual machine");
  EXPECT_EQ(said.cost, Cost::kPeriods);
  std::ifstream readme("README.md");  // tests run in the top folder of the project
  std::string text;
  for (std::string word; readme >> word;) text += word + " ";  // lines end anywhere
  const auto begin = text.find("On a virtual machine the host ");
  ASSERT_NE(begin, std::string::npos);
  const auto sentences = text.substr(begin, text.find("- **", begin) - begin);
  for (const auto* both : {"the host", "milliseconds", "missed", "awake", "`run` misses more", "cyclictest"}) {
    EXPECT_THAT(said.consequence, HasSubstr(both));
    EXPECT_THAT(sentences, HasSubstr(both));
  }
  EXPECT_THAT(said.remedy, HasSubstr("physical machine"));
}

TEST_F(RealtimePlatformTest, TheTickIsJudgedForTheCpuOfTheThread) {
  EXPECT_THAT(item("timer tick").effective, HasSubstr("no NO_HZ_FULL"));
  write("/sys/devices/system/cpu/nohz_full", "  (null)");
  EXPECT_FALSE(item("timer tick").ok);
  EXPECT_EQ(item("timer tick").remedy, "boot with nohz_full=1");
  write("/sys/devices/system/cpu/nohz_full", "1-3");
  EXPECT_TRUE(item("timer tick", 1).ok);
  EXPECT_FALSE(item("timer tick", 0).ok);
  EXPECT_FALSE(item("timer tick", std::nullopt).ok);
}

TEST_F(RealtimePlatformTest, CallbacksMoveByTheirParameterOrWithTheTick) {
  EXPECT_FALSE(item("RCU callbacks").ok);
  write("/proc/cmdline", "rcu_nocbs=2 quiet");
  EXPECT_FALSE(item("RCU callbacks", 1).ok);
  EXPECT_TRUE(item("RCU callbacks", 2).ok);
  write("/proc/cmdline", "rcu_nocbs=all");
  EXPECT_TRUE(item("RCU callbacks", 1).ok);
  write("/proc/cmdline", "nohz_full=1 quiet xrcu_nocbs=0");
  EXPECT_TRUE(item("RCU callbacks", 1).ok);
  write("/proc/cmdline", "rcu_nocbs=1 rcu_nocbs=0");
  EXPECT_FALSE(item("RCU callbacks", 1).ok) << "the last one counts";
}

TEST_F(RealtimePlatformTest, InterruptsOfDevicesOnTheCpuAreNamed) {
  EXPECT_TRUE(item("device interrupts").ok);
  const auto interrupt = [this](int number, const std::string& action, const std::string& may,
                                const std::string& does) {
    const auto folder = "/proc/irq/" + std::to_string(number);
    write(folder + "/smp_affinity_list", may);
    if (!does.empty()) write(folder + "/effective_affinity_list", does);
    if (!action.empty()) write(folder + "/" + action + "/spurious", "");
  };
  interrupt(9, "acpi", "0-3", "0");
  interrupt(4, "", "1", "1");  // has no device
  EXPECT_TRUE(item("device interrupts", 1).ok) << item("device interrupts", 1).effective;
  interrupt(120, "nvme0q1", "0-3", "1");
  interrupt(35, "eth0-rx-0", "0-3", "");  // an older kernel: the interrupt may still use this CPU
  EXPECT_EQ(item("device interrupts", 1).effective, "2 on it: 35 (eth0-rx-0), 120 (nvme0q1)");
  EXPECT_THAT(item("device interrupts", 1).remedy, HasSubstr("/proc/irq/35/smp_affinity_list"));
  for (int more = 40; more < 45; ++more) interrupt(more, "disk", "1", "1");
  EXPECT_THAT(item("device interrupts", 1).effective,
              testing::AllOf(testing::StartsWith("7 on it:"), testing::EndsWith(", ...")));
  EXPECT_TRUE(item("device interrupts", std::nullopt).ok) << "of no CPU in particular";
}

TEST_F(RealtimePlatformTest, TheDeepestIdleStateThatIsEnabledCounts) {
  EXPECT_TRUE(item("idle states").ok) << "there is none";
  const auto state = [this](int number, const std::string& name, int latency_us, int disable) {
    const auto folder = "/sys/devices/system/cpu/cpu1/cpuidle/state" + std::to_string(number);
    write(folder + "/name", name);
    write(folder + "/latency", std::to_string(latency_us));
    write(folder + "/disable", std::to_string(disable));
  };
  state(0, "POLL", 0, 0);
  state(1, "C1", 2, 0);
  EXPECT_TRUE(item("idle states").ok);
  EXPECT_EQ(item("idle states").effective, "C1 takes 2 us to leave");
  state(2, "C6", 133, 0);
  EXPECT_FALSE(item("idle states").ok);
  EXPECT_EQ(item("idle states").cost, Cost::kPeriods);
  EXPECT_EQ(item("idle states").effective, "C6 takes 133 us to leave");
  state(2, "C6", 133, 1);
  EXPECT_TRUE(item("idle states").ok) << "switched off";
}

TEST_F(RealtimePlatformTest, ASiblingMayBeIsolatedToo) {
  write("/sys/devices/system/cpu/cpu1/topology/thread_siblings_list", "1");
  EXPECT_TRUE(item("hyper-threading").ok);
  write("/sys/devices/system/cpu/cpu1/topology/thread_siblings_list", "1,5");
  EXPECT_FALSE(item("hyper-threading").ok);
  EXPECT_EQ(item("hyper-threading").effective, "CPU 1 shares its core with CPU 5");
  EXPECT_THAT(item("hyper-threading").remedy, HasSubstr("cpu5/online"));
  write("/sys/devices/system/cpu/isolated", "1,5");
  EXPECT_TRUE(item("hyper-threading").ok);
}

TEST_F(RealtimePlatformTest, ManagementInterruptsAreCountedWhereTheProcessorCounts) {
  EXPECT_EQ(item("management interrupts").effective, "not counted by this processor");
  // Bytes 34h to 3Bh of a simulated device: 5, little-endian.
  write("/dev/cpu/1/msr", std::string(0x34, 'x') + std::string("\5\0\0\0\0\0\0\0", 8));
  EXPECT_FALSE(item("management interrupts").ok);
  EXPECT_EQ(item("management interrupts").effective, "5 since the machine was started");
  write("/dev/cpu/1/msr", std::string(0x34, 'x') + std::string(8, '\0'));
  EXPECT_TRUE(item("management interrupts").ok);
}

TEST_F(RealtimePlatformTest, EveryFindingTellsWhatItCosts) {
  write("/proc/cpuinfo", "flags : hypervisor");
  write("/proc/sys/kernel/sched_rt_runtime_us", "950000");
  write("/proc/sys/kernel/sched_rt_period_us", "1000000");
  int findings = 0;
  for (const auto& found : inspect_platform({.root = root(), .uname_version = "#1 SMP"}, 1)) {
    if (found.ok) continue;
    ++findings;
    EXPECT_NE(found.cost, Cost::kUnknown) << found.name;
    EXPECT_FALSE(found.consequence.empty()) << found.name;
    EXPECT_FALSE(found.remedy.empty()) << found.name;
  }
  EXPECT_EQ(findings, 6) << "kernel, virtual machine, isolation, tick, callbacks, throttling";
}

TEST_F(RealtimePlatformTest, LoadIsTheShareBetweenTwoReadings) {
  write("/proc/stat",
        "cpu  1 1 1 1 1 1 1 1\ncpu0 9 9 9 9 9 9 9 9\ncpu1 100 10 20 1000 5 3 2 7 1 1\ncpu10 0 0 0 0 0 0 0 0");
  const auto before = read_cpu_times({.root = root(), .uname_version = ""}, 1);
  ASSERT_TRUE(before);
  EXPECT_EQ(before->busy, 135u);
  EXPECT_EQ(before->idle, 1005u);
  EXPECT_EQ(before->stolen, 7u);
  EXPECT_FALSE(read_cpu_times({.root = root(), .uname_version = ""}, 2));
  const auto load = [&](std::uint64_t busy, std::uint64_t idle, std::uint64_t stolen) {
    return inspect_load(1, *before, {before->busy + busy, before->idle + idle, before->stolen + stolen});
  };
  EXPECT_TRUE(load(5, 95, 0).ok);
  EXPECT_FALSE(load(6, 94, 0).ok);
  EXPECT_EQ(load(30, 70, 0).effective, "30 %");
  EXPECT_EQ(load(30, 60, 10).effective, "30 %, 10 % taken by the hypervisor");
  EXPECT_EQ(load(0, 90, 10).cost, Cost::kPeriods);
  EXPECT_EQ(load(0, 0, 0).effective, "0 %");
}

TEST(RealtimePlatform, ThisMachineHasAVersionAndIsLookedAtFromEverySide) {
  const PlatformSource source = PlatformSource::this_machine();
  EXPECT_THAT(source.uname_version, testing::StartsWith("#"));
  EXPECT_EQ(inspect_platform(source, std::nullopt).size(), 14u);
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
