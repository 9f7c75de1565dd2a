#pragma once

#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"

namespace driveline::bridge {

/// What a publisher of this line is to do.
[[nodiscard]] DdsConfig config_of(const snapshot::FeedDescription& description);

}  // namespace driveline::bridge
