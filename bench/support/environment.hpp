#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace driveline::bench {

/// The machine and the build behind the figures.
struct Environment {
  std::string kernel;
  std::string kernel_build;    ///< e.g. "#1 SMP PREEMPT_RT Debian 6.1.90-1": shows the preemption model
  std::string kernel_options;  ///< its command line, without the arguments for init
  std::string cpu;
  unsigned cores = 0;
  std::string isolated;                 ///< isolated processors, e.g. "2-3"; empty: none
  std::string governor;                 ///< frequency governor of the last processor; empty: the kernel has none
  std::vector<std::string> interfaces;  ///< with a device: name, driver, speed, coalescing
  std::string compiler;
  std::string commit;  ///< empty: not built from a checkout
  bool virtual_machine = false;
  std::string build;       ///< build type, e.g. "Release", "Release, LTO"
  std::string date;        ///< UTC, e.g. "2026-01-31"
  double other_load = 0;   ///< average number of processors used by other programs since watch_machine()
  double stolen_load = 0;  ///< average number of processors withheld by the host of a virtual machine since then
};

/// Starts measuring the load by other programs, and reads the network interfaces, which are invisible after entering a
/// private network namespace. Call it once, before the measurement.
void watch_machine();

[[nodiscard]] Environment environment();
/// environment() in the form of the benchmark documents.
[[nodiscard]] nlohmann::ordered_json environment_json();

/// Resident memory of this process, in bytes; 0: the kernel does not report it.
[[nodiscard]] std::size_t resident_bytes();
/// Memory that this single-threaded process has allocated and not freed, in bytes.
[[nodiscard]] std::size_t heap_bytes();

}  // namespace driveline::bench
