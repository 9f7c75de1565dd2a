#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace driveline::bench {

/// Where figures come from.
struct Environment {
  std::string kernel;
  std::string cpu;
  unsigned cores = 0;
  std::string compiler;
  std::string commit;  ///< empty when it was not built from a checkout
  bool virtual_machine = false;
};

[[nodiscard]] Environment environment();
/// environment() as the documents of the benchmarks have it.
[[nodiscard]] nlohmann::ordered_json environment_json();

/// Memory of this process that is resident now, in bytes; 0 when the kernel does not say.
[[nodiscard]] std::size_t resident_bytes();

}  // namespace driveline::bench
