#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace driveline::test {

/// A number from the environment, such as the length of a campaign; `otherwise` if the variable is not set.
inline unsigned environment(const char* name, unsigned otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<unsigned>(std::strtoul(text, nullptr, 10));
}

/// How many of the `all` runs of a campaign, or rounds of a sweep, this build makes: all of them, or one of
/// DRIVELINE_CAMPAIGN_SHARE where each takes several times as long, in a build with sanitizers (CMake sets the
/// variable). At least one. `.ci/run` makes all of them in the release build.
template <typename Count>
Count share_of(Count all) {
  const auto share = static_cast<Count>(std::max(1U, environment("DRIVELINE_CAMPAIGN_SHARE", 1)));
  return (all + share - 1) / share;
}

}  // namespace driveline::test
