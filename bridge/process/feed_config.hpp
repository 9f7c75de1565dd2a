#pragma once

#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

namespace driveline::bridge {

/// Configuration of the publisher of a line, from the description of its feed.
[[nodiscard]] DdsConfig config_of(const snapshot::FeedDescription& description);

}  // namespace driveline::bridge
