#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace driveline::bench {

/// Machine and build that figures come from.
struct Environment {
  std::string kernel;
  std::string kernel_build;    ///< e.g. "#1 SMP PREEMPT_RT Debian 6.1.90-1": how it may be preempted
  std::string kernel_options;  ///< its command line, without what is for init
  std::string cpu;
  unsigned cores = 0;
  std::string isolated;                 ///< processors that the kernel keeps free, e.g. "2-3"; empty: none
  std::string governor;                 ///< of the clock of the last processor; empty: the kernel has none
  std::vector<std::string> interfaces;  ///< with a device: name, driver, speed, coalescing
  std::string compiler;
  std::string commit;  ///< empty when it was not built from a checkout
  bool virtual_machine = false;
  std::string build;       ///< kind of build, e.g. "Release", "Release, LTO"
  std::string date;        ///< UTC, e.g. "2026-01-31"
  double other_load = 0;   ///< processors that others kept busy since watch_machine(), on average
  double stolen_load = 0;  ///< processors that the host of a virtual machine kept for itself meanwhile, on average
};

/// Starts measuring the load by other programs, and looks at the network interfaces, which a program that goes into a
/// network namespace of its own sees no longer. Once, before the measurement.
void watch_machine();

[[nodiscard]] Environment environment();
/// environment() as the documents of the benchmarks have it.
[[nodiscard]] nlohmann::ordered_json environment_json();

/// Memory of this process that is resident now, in bytes; 0 when the kernel does not say.
[[nodiscard]] std::size_t resident_bytes();
/// Memory that this process has allocated and not given back, in bytes, of a program of one thread.
[[nodiscard]] std::size_t heap_bytes();

}  // namespace driveline::bench
