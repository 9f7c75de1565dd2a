// Checks of the kernel as a whole: preemption, throttling, cgroup budget, clock source, virtual machine.

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>

#include "checks.hpp"

namespace driveline::rt::checks {

namespace {

/// Current preemption model of a kernel with PREEMPT_DYNAMIC; empty if it is unknown.
std::string dynamic_model(const PlatformSource& source) {
  // debugfs marks the active model: "none voluntary (full) lazy".
  const auto models = first_line(source.root + "/sys/kernel/debug/sched/preempt").value_or("");
  const auto open = models.find('(');
  const auto close = models.find(')');
  if (open != std::string::npos && close != std::string::npos && open < close) {
    return models.substr(open + 1, close - open - 1);
  }
  return boot_parameter(source, "preempt").value_or("");
}

std::string preemption_model(const PlatformSource& source) {
  if (first_line(source.root + "/sys/kernel/realtime").value_or("0") == "1") return "PREEMPT_RT";
  // Longer names first: each contains the shorter ones.
  for (const char* model : {"PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT"}) {
    if (source.uname_version.find(model) != std::string::npos) return model;
  }
  return "no preemption in the kernel";
}

/// The cgroup of this process under the controller `cpu` (cgroup v1); nullopt without that controller.
std::optional<std::string> cpu_cgroup(const PlatformSource& source) {
  std::ifstream file{source.root + "/proc/self/cgroup"};
  for (std::string line; std::getline(file, line);) {
    // Format: hierarchy:controllers:path
    const auto first = line.find(':');
    const auto second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    std::istringstream controllers{line.substr(first + 1, second - first - 1)};
    for (std::string name; std::getline(controllers, name, ',');) {
      if (name == "cpu") return line.substr(second + 1);
    }
  }
  return std::nullopt;
}

}  // namespace

RealtimeItem preemption(const PlatformSource& source) {
  auto model = preemption_model(source);
  const bool realtime = model == "PREEMPT_RT";
  if (model == "PREEMPT_DYNAMIC") {
    if (const auto dynamic = dynamic_model(source); !dynamic.empty()) model += " (" + dynamic + ")";
  }
  auto item = fine("kernel preemption", "PREEMPT_RT", model);
  if (realtime) return item;
  return found(std::move(item), Cost::kPeriods,
               "a wake-up is delayed while the kernel works for another process: some 100 us under load, more for some "
               "system calls",
               "boot a PREEMPT_RT kernel (Debian: linux-image-rt-amd64) for bounded wake-up latencies");
}

RealtimeItem throttling(const PlatformSource& source) {
  const auto runtime_us = first_line(source.root + "/proc/sys/kernel/sched_rt_runtime_us");
  const auto period_us = first_line(source.root + "/proc/sys/kernel/sched_rt_period_us");
  auto item = fine("real-time throttling", "off", "off");
  if (!runtime_us || !period_us) {
    item.effective = "unknown (kernel.sched_rt_runtime_us cannot be read)";
    item.ok = false;
  } else if (*runtime_us != "-1") {
    item.effective = "possible after " + *runtime_us + " us of CPU time in every " + *period_us + " us";
    return found(
        std::move(item), Cost::kMicroseconds,
        "no effect while the cycle sleeps in every period; a thread that never sleeps is stopped for milliseconds",
        "none needed while the cycle sleeps in every period; `sysctl -w kernel.sched_rt_runtime_us=-1` turns it off");
  }
  return item;
}

RealtimeItem group_scheduling(const PlatformSource& source) {
  auto item = fine("real-time group budget", "none, or one above 0", "none");
  const auto group = cpu_cgroup(source);
  if (!group) return item;
  const auto file = "/sys/fs/cgroup/cpu" + (*group == "/" ? "" : *group) + "/cpu.rt_runtime_us";
  const auto budget_us = first_line(source.root + file);
  if (!budget_us) return item;  // a kernel without RT_GROUP_SCHED
  item.effective = *budget_us + " us in the cgroup " + *group;
  if (*budget_us != "0") return item;
  return found(
      std::move(item), Cost::kPrevents,
      "SCHED_FIFO is refused, even to root: a kernel with RT_GROUP_SCHED gives a new cgroup no real-time budget",
      "`echo 900000 > " + file + "` (and of the cgroups above it), or start from the root cgroup");
}

RealtimeItem clock_source(const PlatformSource& source) {
  const auto name = first_line(source.root + "/sys/devices/system/clocksource/clocksource0/current_clocksource");
  auto item = fine("clock source", "tsc", name.value_or("unknown"));
  // Counters of the CPU architecture and of the hypervisor are read without a system call.
  constexpr std::array<std::string_view, 5> kFast = {"tsc", "arch_sys_counter", "kvm-clock",
                                                     "hyperv_clocksource_tsc_page", "timebase"};
  if (!name || std::find(kFast.begin(), kFast.end(), *name) != kFast.end()) return item;
  return found(std::move(item), Cost::kMicroseconds,
               "each reading of the clock is a system call to a slow device: about 1 us",
               "boot with clocksource=tsc tsc=reliable, if the processor's counter is constant");
}

RealtimeItem virtual_machine(const PlatformSource& source) {
  auto item = fine("virtual machine", "none", "none");
  std::ifstream cpuinfo{source.root + "/proc/cpuinfo"};
  bool guest = false;
  for (std::string line; !guest && std::getline(cpuinfo, line);) {
    guest = line.starts_with("flags") && (line + " ").find(" hypervisor ") != std::string::npos;
  }
  if (!guest) return item;
  item.effective = "a guest of a hypervisor";
  const auto vendor = first_line(source.root + "/sys/class/dmi/id/sys_vendor");
  if (vendor) item.effective += " (" + *vendor + ")";
  return found(std::move(item), Cost::kPeriods,
               "the host stops the virtual processor for any time, often for milliseconds, and no clock in the guest "
               "shows it: each stop is missed periods, more of them the longer a cycle is awake, so `run` misses more "
               "than cyclictest, which hardly is",
               "run on a physical machine, or give the guest dedicated processors (pinned, isolated on the host)");
}

}  // namespace driveline::rt::checks
