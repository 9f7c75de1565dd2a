#include "checks.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <vector>

namespace driveline::rt::checks {

namespace {

namespace fs = std::filesystem;

/// Fields of /proc/PID/task/TID/stat (proc(5)) that the check uses.
struct ThreadStat {
  std::string name;  ///< non-printable characters replaced by '?'
  unsigned long flags = 0;
  int priority = 0;
  int policy = SCHED_OTHER;
};

bool is_process_number(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

ThreadStat read_stat(const fs::path& thread) {
  // Field numbers as in the manual; the first field after the name is the state, number 3.
  constexpr int kFlags = 9;
  constexpr int kPriority = 40;
  constexpr int kPolicy = 41;
  ThreadStat stat;
  std::ifstream file(thread / "stat");
  std::string line;
  std::getline(file, line);
  const auto open = line.find('(');
  const auto close = line.rfind(')');
  if (open == std::string::npos || close == std::string::npos || close < open) return stat;
  stat.name = line.substr(open + 1, close - open - 1);
  std::replace_if(
      stat.name.begin(), stat.name.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  std::istringstream fields(line.substr(close + 1));
  std::string field;
  for (int number = 3; number <= kPolicy && fields >> field; ++number) {
    if (number == kFlags) stat.flags = std::strtoul(field.c_str(), nullptr, 10);
    if (number == kPriority) stat.priority = std::atoi(field.c_str());
    if (number == kPolicy) stat.policy = std::atoi(field.c_str());
  }
  return stat;
}

bool is_realtime_of_a_program(const ThreadStat& stat) {
  constexpr unsigned long kKernelThread = 0x0020'0000;  // PF_KTHREAD
  return (stat.policy == SCHED_FIFO || stat.policy == SCHED_RR) && (stat.flags & kKernelThread) == 0;
}

/// The CPUs that a thread may run on, in the kernel's notation.
std::string allowed_cpus(const fs::path& thread) {
  constexpr std::string_view kKey = "Cpus_allowed_list:";
  std::ifstream status(thread / "status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, kKey.size(), kKey) != 0) continue;
    const auto begin = line.find_first_not_of(" \t", kKey.size());
    return begin == std::string::npos ? std::string{} : line.substr(begin);
  }
  return {};
}

/// Adds the real-time threads of `process` that are pinned to `cpu`.
void collect_neighbours(const fs::path& process, int cpu, std::vector<std::string>& found) {
  std::error_code error;
  for (fs::directory_iterator thread(process / "task", error), end; !error && thread != end; thread.increment(error)) {
    const auto stat = read_stat(thread->path());
    if (!is_realtime_of_a_program(stat) || allowed_cpus(thread->path()) != std::to_string(cpu)) continue;
    found.push_back(stat.name + " (process " + process.filename().string() + ", priority " +
                    std::to_string(stat.priority) + ")");
  }
}

}  // namespace

RealtimeItem neighbours(const PlatformSource& source, Cpu cpu) {
  auto item = fine("neighbours", cpu ? "no other real-time thread on CPU " + std::to_string(*cpu) : "not requested",
                   cpu ? "none" : "not checked on all CPUs");
  if (!cpu) return item;
  const auto self = std::to_string(getpid());
  std::vector<std::string> list;
  std::error_code error;
  for (fs::directory_iterator process(source.root + "/proc", error), end; !error && process != end;
       process.increment(error)) {
    const auto name = process->path().filename().string();
    if (is_process_number(name) && name != self) collect_neighbours(process->path(), *cpu, list);
  }
  if (list.empty()) return item;
  item.effective.clear();
  for (const auto& neighbour : list) item.effective += (item.effective.empty() ? "" : ", ") + neighbour;
  return found(std::move(item), Cost::kPeriods,
               "a thread of the same or a higher priority can delay the cycle without limit",
               "give each a CPU of its own ([realtime] `cpu` of a master, `simulation_cpu` of `simulate`)");
}

}  // namespace driveline::rt::checks
