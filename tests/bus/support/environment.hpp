#pragma once

#include <cstdlib>

namespace driveline::bus_test {

/// A number that the environment may give, as for the length of a campaign.
inline unsigned environment(const char* name, unsigned otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<unsigned>(std::strtoul(text, nullptr, 10));
}

}  // namespace driveline::bus_test
