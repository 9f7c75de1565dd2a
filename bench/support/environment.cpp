#include "support/environment.hpp"

#include <malloc.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>

#include "driveline/port/interface_check.hpp"

namespace driveline::bench {
namespace {

constexpr std::string_view compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "gcc " __VERSION__;
#endif
}

/// Work of the processors so far, in seconds of a single processor.
struct ProcessorTime {
  double passed_s = 0.0;  ///< real time
  double busy_s = 0.0;    ///< all processors, by any program
  double own_s = 0.0;     ///< this program and the tools that it has called
  double stolen_s = 0.0;  ///< requested, but withheld by the host
};

double seconds_of(const rusage& usage) {
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Reads the first line of /proc/stat (proc(5)): user, nice, system, idle, iowait, irq, softirq, steal, in ticks.
ProcessorTime processor_time() {
  ProcessorTime time;
  std::timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  time.passed_s = static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  std::ifstream stat("/proc/stat");
  std::string name;
  double ticks[8] = {};
  stat >> name;
  for (double& value : ticks) stat >> value;
  const auto rate = static_cast<double>(sysconf(_SC_CLK_TCK));
  time.busy_s = (ticks[0] + ticks[1] + ticks[2] + ticks[5] + ticks[6]) / rate;
  time.stolen_s = ticks[7] / rate;
  rusage self{};
  rusage children{};
  getrusage(RUSAGE_SELF, &self);
  getrusage(RUSAGE_CHILDREN, &children);
  time.own_s = seconds_of(self) + seconds_of(children);
  return time;
}

const ProcessorTime& watched_since() {
  static const ProcessorTime kBegin = processor_time();
  return kBegin;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[sizeof "2026-01-31"] = {};
  return std::strftime(text, sizeof text, "%Y-%m-%d", &parts) > 0 ? text : "";
}

/// Rounds to hundredths of a processor, the resolution of ticks.
double hundredths(double load) {
  return std::max(0.0, std::round(load * 100.0) / 100.0);
}

/// The first line of a file of the kernel; empty: there is no such file.
std::string first_line(const std::string& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

std::string interface_text(const port::InterfaceFacts& facts) {
  auto text = fmt::format("{}: {}", facts.name, facts.driver);
  if (!facts.running) return text + ", no link";
  if (facts.speed_mbit_s) text += fmt::format(", {} Mbit/s", *facts.speed_mbit_s);
  if (!facts.coalescing) return text + ", coalescing unknown";
  const auto& waits = *facts.coalescing;
  return text + fmt::format(", coalescing rx {} us, tx {} us{}", waits.rx_usecs, waits.tx_usecs,
                            waits.adaptive ? ", adaptive" : "");
}

/// The network interfaces with a device.
const std::vector<std::string>& network_cards() {
  static const std::vector<std::string> kCards = [] {
    std::vector<std::string> cards;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator("/sys/class/net", none)) {
      if (!std::filesystem::exists(entry.path() / "device", none)) continue;
      if (const auto facts = port::read_interface_facts(entry.path().filename().string()))
        cards.push_back(interface_text(*facts));
    }
    std::sort(cards.begin(), cards.end());
    return cards;
  }();
  return kCards;
}

}  // namespace

void watch_machine() {
  network_cards();
  watched_since();
}

Environment environment() {
  Environment result;
  utsname system{};
  uname(&system);
  result.kernel = system.release;
  result.kernel_build = system.version;
  // The arguments after the two dashes are for init.
  result.kernel_options = first_line("/proc/cmdline");
  result.kernel_options.resize(std::min(result.kernel_options.find(" -- "), result.kernel_options.size()));
  result.cpu = "unknown";
  result.cores = std::thread::hardware_concurrency();
  result.isolated = first_line("/sys/devices/system/cpu/isolated");
  result.governor =
      first_line(fmt::format("/sys/devices/system/cpu/cpu{}/cpufreq/scaling_governor", std::max(1U, result.cores) - 1));
  result.interfaces = network_cards();
  result.compiler = compiler();
  result.commit = DRIVELINE_COMMIT;
  result.build = DRIVELINE_BUILD;
  result.date = today();
  const auto& begin = watched_since();
  const auto end = processor_time();
  if (const double passed_s = end.passed_s - begin.passed_s; passed_s > 0.0) {
    result.other_load = hundredths(((end.busy_s - begin.busy_s) - (end.own_s - begin.own_s)) / passed_s);
    result.stolen_load = hundredths((end.stolen_s - begin.stolen_s) / passed_s);
  }
  std::ifstream info("/proc/cpuinfo");
  bool named = false;
  for (std::string line; std::getline(info, line);) {
    const auto colon = line.find(": ");
    if (colon == std::string::npos) continue;
    if (!named && line.starts_with("model name")) {
      result.cpu = line.substr(colon + 2);
      named = true;
    }
    if (line.starts_with("flags") && (line + ' ').find(" hypervisor ") != std::string::npos)
      result.virtual_machine = true;
  }
  return result;
}

nlohmann::ordered_json environment_json() {
  const auto where = environment();
  return {{"kernel", where.kernel},
          {"kernel_build", where.kernel_build},
          {"cpu", where.cpu},
          {"kernel_options", where.kernel_options},
          {"cores", where.cores},
          {"isolated_cpus", where.isolated},
          {"governor", where.governor},
          {"interfaces", where.interfaces},
          {"compiler", where.compiler},
          {"commit", where.commit},
          {"virtual_machine", where.virtual_machine},
          {"build", where.build},
          {"date", where.date},
          {"other_load", where.other_load},
          {"stolen_load", where.stolen_load}};
}

std::size_t heap_bytes() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t total_pages = 0;
  std::size_t resident_pages = 0;
  if (!(statm >> total_pages >> resident_pages)) return 0;
  return resident_pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace driveline::bench
