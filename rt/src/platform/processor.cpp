// Checks of the CPU of the thread: isolation, tick, RCU callbacks, interrupts, governor, idle states, siblings, SMIs,
// load.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "checks.hpp"

namespace driveline::rt::checks {

namespace {

namespace fs = std::filesystem;

std::string folder_of(const PlatformSource& source, Cpu cpu) {
  return source.root + "/sys/devices/system/cpu/cpu" + std::to_string(cpu.value_or(0));
}

/// "CPU 1", or a phrase for the case that no CPU was chosen.
std::string name_of(Cpu cpu) {
  return cpu ? "CPU " + std::to_string(*cpu) : "the CPU of the cycle";
}

std::string number_of(Cpu cpu) {
  return cpu ? std::to_string(*cpu) : "N";
}

/// A device interrupt.
struct Interrupt {
  std::string number;
  std::string name;  ///< name of its action: the name of the folder in /proc/irq/N
};

/// The device interrupts that the kernel delivers to `cpu`.
std::vector<Interrupt> interrupts_on(const PlatformSource& source, int cpu) {
  std::vector<Interrupt> list;
  std::error_code error;
  for (fs::directory_iterator irq(source.root + "/proc/irq", error), end; !error && irq != end; irq.increment(error)) {
    const auto folder = irq->path();
    // Effective affinity; older kernels report only the allowed one.
    auto where = first_line(folder / "effective_affinity_list");
    if (!where || where->empty()) where = first_line(folder / "smp_affinity_list");
    if (!where || !cpu_list_contains(*where, cpu)) continue;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.is_directory(ignored)) list.push_back({folder.filename().string(), entry.path().filename().string()});
    }
  }
  std::sort(list.begin(), list.end(), [](const Interrupt& a, const Interrupt& b) {
    return a.number.size() != b.number.size() ? a.number.size() < b.number.size() : a.number < b.number;
  });
  return list;
}

std::optional<long> number_in(const std::string& file) {
  const auto text = first_line(file);
  if (!text) return std::nullopt;
  long value = 0;
  const auto parsed = std::from_chars(text->data(), text->data() + text->size(), value);
  if (parsed.ec != std::errc{}) return std::nullopt;
  return value;
}

}  // namespace

RealtimeItem isolation(const PlatformSource& source, Cpu cpu) {
  const std::string list = first_line(source.root + "/sys/devices/system/cpu/isolated").value_or("");
  auto item = fine("CPU isolation", cpu ? name_of(cpu) + " isolated" : "a CPU of its own",
                   list.empty() ? "no CPU isolated" : "CPUs " + list + " isolated");
  if (cpu && cpu_list_contains(list, *cpu)) return item;
  return found(std::move(item), Cost::kPeriods,
               "programs and kernel work share the CPU and its caches with the cycle: tens to hundreds of us",
               cpu ? "boot with isolcpus=" + number_of(cpu) + " nohz_full=" + number_of(cpu)
                   : "choose a CPU for the thread and isolate it with isolcpus= on the kernel command line");
}

RealtimeItem timer_tick(const PlatformSource& source, Cpu cpu) {
  const auto list = first_line(source.root + "/sys/devices/system/cpu/nohz_full");
  const bool none = !list || list->find_first_of("0123456789") == std::string::npos;  // "(null)" means none
  auto item = fine("timer tick", "stopped on " + name_of(cpu) + " (nohz_full)",
                   !list  ? "ticks on every CPU, the kernel has no NO_HZ_FULL"
                   : none ? "ticks on every CPU"
                          : "stopped on CPUs " + *list);
  if (!none && cpu && cpu_list_contains(*list, *cpu)) return item;
  return found(
      std::move(item), Cost::kMicroseconds, "the tick interrupts the cycle 100 to 1000 times a second, for some us",
      std::string{list ? "boot" : "boot a kernel that has it (Debian's has)"} + " with nohz_full=" + number_of(cpu));
}

RealtimeItem rcu_callbacks(const PlatformSource& source, Cpu cpu) {
  auto list = boot_parameter(source, "rcu_nocbs");
  // A CPU without tick (nohz_full) has its callbacks offloaded as well.
  if (!list) list = boot_parameter(source, "nohz_full");
  auto item = fine("RCU callbacks", "not on " + name_of(cpu) + " (rcu_nocbs)",
                   list ? "moved away from CPUs " + *list : "on every CPU");
  const bool moved = list && cpu && (*list == "all" || cpu_list_contains(*list, *cpu));
  if (moved) return item;
  return found(std::move(item), Cost::kMicroseconds,
               "the kernel frees memory of other programs on this CPU: some us, at times tens",
               "boot with rcu_nocbs=" + number_of(cpu));
}

RealtimeItem interrupts(const PlatformSource& source, Cpu cpu) {
  auto item = fine("device interrupts", "none on " + name_of(cpu), cpu ? "none" : "not checked on all CPUs");
  if (!cpu) return item;
  const auto list = interrupts_on(source, *cpu);
  if (list.empty()) return item;
  constexpr std::size_t kNamed = 4;
  item.effective = std::to_string(list.size()) + " on it:";
  for (std::size_t i = 0; i < std::min(list.size(), kNamed); ++i) {
    item.effective += (i == 0 ? " " : ", ") + list[i].number + " (" + list[i].name + ")";
  }
  if (list.size() > kNamed) item.effective += ", ...";
  return found(std::move(item), Cost::kMicroseconds,
               "each of them delays the cycle by some us, a busy disk or network by tens",
               "boot with irqaffinity= and the other CPUs, or `echo CPUS > /proc/irq/" + list.front().number +
                   "/smp_affinity_list` for each; stop irqbalance, or ban the CPU there");
}

RealtimeItem governor(const PlatformSource& source, Cpu cpu) {
  const auto name = first_line(folder_of(source, cpu) + "/cpufreq/scaling_governor");
  auto item = fine("frequency governor", "performance", name.value_or("none"));
  if (!name || *name == "performance") return item;
  return found(std::move(item), Cost::kMicroseconds,
               "the clock is low when the cycle wakes, and a change of it stops the processor for 10 us and more",
               "`cpupower -c " + std::to_string(cpu.value_or(0)) + " frequency-set -g performance`");
}

RealtimeItem idle_states(const PlatformSource& source, Cpu cpu) {
  // Longest exit latency accepted while the cycle waits. A run avoids deeper states by its own request (CPU wake-up
  // time) if it may open the device.
  constexpr long kShallowUs = 10;
  auto item = fine("idle states", "none that takes more than " + std::to_string(kShallowUs) + " us to leave", "none");
  const std::string idle = folder_of(source, cpu) + "/cpuidle";
  long deepest_us = -1;
  for (int state = 0;; ++state) {
    const auto folder = idle + "/state" + std::to_string(state);
    const auto latency_us = number_in(folder + "/latency");
    if (!latency_us) break;
    if (number_in(folder + "/disable").value_or(0) != 0 || *latency_us <= deepest_us) continue;
    deepest_us = *latency_us;
    item.effective = first_line(folder + "/name").value_or("state " + std::to_string(state)) + " takes " +
                     std::to_string(deepest_us) + " us to leave";
  }
  if (deepest_us <= kShallowUs) return item;
  return found(
      std::move(item), deepest_us >= 100 ? Cost::kPeriods : Cost::kMicroseconds,
      "a wake-up is that much later, unless the run may hold /dev/cpu_dma_latency (`CPU wake-up time` says ok)",
      "let the user open /dev/cpu_dma_latency, or boot with processor.max_cstate=1 intel_idle.max_cstate=1");
}

RealtimeItem siblings(const PlatformSource& source, Cpu cpu) {
  auto item = fine("hyper-threading", "no busy sibling", "none");
  if (!cpu) return item;
  const auto list = first_line(folder_of(source, cpu) + "/topology/thread_siblings_list").value_or("");
  const std::string isolated = first_line(source.root + "/sys/devices/system/cpu/isolated").value_or("");
  std::string others;
  constexpr int kMaxCpus = 4096;
  for (int other = 0; other < kMaxCpus; ++other) {
    if (other == *cpu || !cpu_list_contains(list, other) || cpu_list_contains(isolated, other)) continue;
    if (!others.empty()) others += ',';
    others += std::to_string(other);
  }
  if (others.empty()) return item;
  item.effective = name_of(cpu) + " shares its core with CPU " + others;
  return found(std::move(item), Cost::kMicroseconds,
               "a program on the sibling takes half of the core: the cycle costs up to twice as much",
               "`echo 0 > /sys/devices/system/cpu/cpu" + others.substr(0, others.find(',')) +
                   "/online`, isolate it as well, or switch hyper-threading off in the firmware");
}

RealtimeItem management_interrupts(const PlatformSource& source, Cpu cpu) {
  auto item = fine("management interrupts", "none", "not counted by this processor");
  // MSR_SMI_COUNT of Intel processors (Intel SDM volume 4, table 2-2).
  constexpr off_t kSmiCount = 0x34;
  const std::string device = source.root + "/dev/cpu/" + std::to_string(cpu.value_or(0)) + "/msr";
  const int file = open(device.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return item;
  std::uint64_t count = 0;
  const bool read = pread(file, &count, sizeof count, kSmiCount) == static_cast<ssize_t>(sizeof count);
  close(file);
  if (!read) return item;
  item.effective = std::to_string(count) + " since the machine was started";
  if (count == 0) return item;
  return found(std::move(item), Cost::kPeriods,
               "the firmware stops all processors for 10 us to some ms, and the kernel cannot prevent it",
               "check whether the number grows during a run; switch off USB legacy support and power management in the "
               "firmware");
}

}  // namespace driveline::rt::checks

namespace driveline::rt {

std::optional<CpuTimes> read_cpu_times(const PlatformSource& source, int cpu) {
  std::ifstream file{source.root + "/proc/stat"};
  const std::string key = "cpu" + std::to_string(cpu);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words{line};
    std::string name;
    if (!(words >> name) || name != key) continue;
    // Fields (proc(5)): user nice system idle iowait irq softirq steal
    std::array<std::uint64_t, 8> ticks{};
    for (auto& value : ticks) words >> value;
    return CpuTimes{ticks[0] + ticks[1] + ticks[2] + ticks[5] + ticks[6], ticks[3] + ticks[4], ticks[7]};
  }
  return std::nullopt;
}

RealtimeItem inspect_load(int cpu, const CpuTimes& before, const CpuTimes& after) {
  const std::uint64_t busy = after.busy - before.busy;
  const std::uint64_t stolen = after.stolen - before.stolen;
  const std::uint64_t all = busy + stolen + (after.idle - before.idle);
  const auto share = [all](std::uint64_t ticks) { return all == 0 ? 0 : (100 * ticks + all / 2) / all; };
  auto item = checks::fine("load", "at most 5 % of CPU " + std::to_string(cpu), std::to_string(share(busy)) + " %");
  if (stolen > 0) item.effective += ", " + std::to_string(share(stolen)) + " % taken by the hypervisor";
  constexpr std::uint64_t kQuietPercent = 5;
  if (share(busy) <= kQuietPercent && stolen == 0) return item;
  return checks::found(std::move(item), stolen > 0 ? Cost::kPeriods : Cost::kMicroseconds,
                       "other programs and the kernel work for them use the CPU and its caches",
                       "move them: `taskset -p`, CPUAffinity= of their services, or isolate the CPU");
}

}  // namespace driveline::rt
