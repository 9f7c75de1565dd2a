#pragma once

#include <cstdlib>

namespace driveline::bus_test {

/// A number from the environment, such as the length of a campaign; `otherwise` if the variable is not set.
inline unsigned environment(const char* name, unsigned otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<unsigned>(std::strtoul(text, nullptr, 10));
}

}  // namespace driveline::bus_test
