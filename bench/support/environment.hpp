#pragma once

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

/// Memory of this process that is resident now, in bytes; 0 when the kernel does not say.
[[nodiscard]] std::size_t resident_bytes();

}  // namespace driveline::bench
