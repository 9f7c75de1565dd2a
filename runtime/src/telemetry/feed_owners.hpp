#pragma once

#include <string>
#include <vector>

#include "driveline/snapshot/feed/feed_condition.hpp"

namespace driveline::runtime {

/// Sets the owners of the axes in `condition`, by axis number; empty: none. True: they have changed.
[[nodiscard]] bool set_feed_owners(const std::vector<std::string>& owners, snapshot::FeedCondition& condition);

}  // namespace driveline::runtime
