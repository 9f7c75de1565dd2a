#include "driveline/rt/realtime_platform.hpp"

#include <sched.h>
#include <sys/utsname.h>

#include <charconv>
#include <fstream>
#include <sstream>

#include "checks.hpp"

namespace driveline::rt {

namespace checks {

std::optional<std::string> first_line(const std::string& path) {
  std::ifstream file{path};
  std::string line;
  if (!file || !std::getline(file, line)) return std::nullopt;
  return line;
}

RealtimeItem fine(std::string name, std::string requested, std::string found) {
  return {.name = std::move(name), .requested = std::move(requested), .effective = std::move(found), .remedy = {}};
}

RealtimeItem found(RealtimeItem item, Cost cost, std::string consequence, std::string remedy) {
  item.ok = false;
  item.cost = cost;
  item.consequence = std::move(consequence);
  item.remedy = std::move(remedy);
  return item;
}

std::optional<std::string> boot_parameter(const PlatformSource& source, const std::string& name) {
  std::istringstream words{first_line(source.root + "/proc/cmdline").value_or("")};
  std::optional<std::string> value;
  for (std::string word; words >> word;) {
    if (word == name) value = "";
    if (word.starts_with(name + "=")) value = word.substr(name.size() + 1);  // the last one counts, as in the kernel
  }
  return value;
}

}  // namespace checks

PlatformSource PlatformSource::this_machine() {
  utsname name{};
  uname(&name);  // fails only on an invalid pointer
  return {.root = "", .uname_version = static_cast<const char*>(name.version)};
}

std::vector<RealtimeItem> inspect_platform(const PlatformSource& source, std::optional<int> cpu) {
  // Order matters: among items of equal cost the first is the most important one. Another thread on the CPU is easier
  // to remedy than the kernel.
  return {checks::group_scheduling(source), checks::neighbours(source, cpu), checks::preemption(source),
          checks::virtual_machine(source),  checks::isolation(source, cpu),  checks::management_interrupts(source, cpu),
          checks::idle_states(source, cpu), checks::governor(source, cpu),   checks::interrupts(source, cpu),
          checks::siblings(source, cpu),    checks::timer_tick(source, cpu), checks::rcu_callbacks(source, cpu),
          checks::clock_source(source),     checks::throttling(source)};
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
