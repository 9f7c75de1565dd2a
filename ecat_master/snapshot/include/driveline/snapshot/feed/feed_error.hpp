#pragma once

#include <string>

namespace driveline::snapshot {

/// Why a feed cannot be read: the region, and what is wrong with it.
struct FeedError {
  const char* region;  ///< "description", "status", "cycles", "events", "condition", "return"
  std::string reason;  ///< describe(rt::SharedRegionError), or what is missing in its content
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const FeedError& error) {
  return "feed, " + std::string{error.region} + ": " + error.reason;
}

}  // namespace driveline::snapshot
