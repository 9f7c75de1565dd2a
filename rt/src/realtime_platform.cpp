#include "driveline/rt/realtime_platform.hpp"

#include <sched.h>
#include <sys/utsname.h>

#include <charconv>
#include <fstream>

#include "realtime_neighbours.hpp"

namespace driveline::rt {

namespace {

/// First line of a file of /proc or /sys; nothing if it cannot be read.
std::optional<std::string> first_line(const std::string& path) {
  std::ifstream file{path};
  if (!file) {
    return std::nullopt;
  }
  std::string line;
  std::getline(file, line);
  return line;
}

RealtimeItem preemption(const PlatformSource& source) {
  RealtimeItem item{.name = "kernel preemption", .requested = "PREEMPT_RT", .effective = {}, .remedy = {}};
  const bool realtime = first_line(source.root + "/sys/kernel/realtime").value_or("0") == "1";
  // The longer names first: each contains the shorter ones.
  for (const char* model : {"PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT"}) {
    if (item.effective.empty() && source.uname_version.find(model) != std::string::npos) {
      item.effective = model;
    }
  }
  if (realtime) {
    item.effective = "PREEMPT_RT";
  } else if (item.effective.empty()) {
    item.effective = "no preemption in the kernel";
  }
  item.ok = item.effective == "PREEMPT_RT";
  if (!item.ok) {
    item.remedy = "boot a PREEMPT_RT kernel (Debian: linux-image-rt-amd64) for bounded wake-up latencies";
  }
  return item;
}

RealtimeItem throttling(const PlatformSource& source) {
  RealtimeItem item{.name = "real-time throttling", .requested = "off", .effective = {}, .remedy = {}};
  const auto runtime_us = first_line(source.root + "/proc/sys/kernel/sched_rt_runtime_us");
  const auto period_us = first_line(source.root + "/proc/sys/kernel/sched_rt_period_us");
  if (!runtime_us || !period_us) {
    item.effective = "unknown (kernel.sched_rt_runtime_us cannot be read)";
    item.ok = false;
  } else if (*runtime_us == "-1") {
    item.effective = "off";
  } else {
    item.effective = "possible after " + *runtime_us + " us of CPU time in every " + *period_us + " us";
    item.ok = false;
    item.remedy =
        "none needed while the cycle sleeps in every period; `sysctl -w kernel.sched_rt_runtime_us=-1` turns it off";
  }
  return item;
}

RealtimeItem isolation(const PlatformSource& source, std::optional<int> cpu) {
  RealtimeItem item{.name = "CPU isolation",
                    .requested = cpu ? "CPU " + std::to_string(*cpu) + " isolated" : "a CPU of its own",
                    .effective = {},
                    .remedy = {}};
  const std::string list = first_line(source.root + "/sys/devices/system/cpu/isolated").value_or("");
  item.effective = list.empty() ? "no CPU isolated" : "CPUs " + list + " isolated";
  item.ok = cpu && cpu_list_contains(list, *cpu);
  if (!item.ok) {
    item.remedy = cpu ? "boot with isolcpus=" + std::to_string(*cpu) + " nohz_full=" + std::to_string(*cpu)
                      : "choose a CPU for the thread and isolate it with isolcpus= on the kernel command line";
  }
  return item;
}

RealtimeItem governor(const PlatformSource& source, std::optional<int> cpu) {
  RealtimeItem item{.name = "frequency governor", .requested = "performance", .effective = "none", .remedy = {}};
  const std::string number = std::to_string(cpu.value_or(0));
  const auto name = first_line(source.root + "/sys/devices/system/cpu/cpu" + number + "/cpufreq/scaling_governor");
  if (name) {
    item.effective = *name;
    item.ok = *name == "performance";
  }
  if (!item.ok) {
    item.remedy = "`cpupower -c " + number + " frequency-set -g performance`";
  }
  return item;
}

}  // namespace

PlatformSource PlatformSource::this_machine() {
  utsname name{};
  uname(&name);  // fails only on an invalid pointer
  return {.root = "", .uname_version = static_cast<const char*>(name.version)};
}

std::vector<RealtimeItem> inspect_platform(const PlatformSource& source, std::optional<int> cpu) {
  return {preemption(source), throttling(source), isolation(source, cpu), inspect_neighbours(source.root, cpu),
          governor(source, cpu)};
}

std::optional<int> allowed_cpu_besides(int cpu) noexcept {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return std::nullopt;
  for (int other = CPU_SETSIZE - 1; other >= 0; --other) {
    if (other != cpu && CPU_ISSET(other, &allowed)) return other;
  }
  return std::nullopt;
}

bool cpu_list_contains(std::string_view list, int cpu) noexcept {
  const char* at = list.data();
  const char* const end = at + list.size();
  while (at < end) {
    int first = 0;
    auto parsed = std::from_chars(at, end, first);
    int last = first;
    if (parsed.ec == std::errc{} && parsed.ptr < end && *parsed.ptr == '-') {
      parsed = std::from_chars(parsed.ptr + 1, end, last);
    }
    if (parsed.ec != std::errc{} || (parsed.ptr < end && *parsed.ptr != ',')) {
      return false;  // not a list of CPUs
    }
    if (first <= cpu && cpu <= last) {
      return true;
    }
    at = parsed.ptr + 1;
  }
  return false;
}

}  // namespace driveline::rt
