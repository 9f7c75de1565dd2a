#pragma once

#include <cstdint>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/snapshot/feed/feed_records.hpp"
#include "driveline/snapshot/line_status.hpp"

namespace driveline::runtime {

/// Returns the feed's description of a line. Errors (kSetting): more axes or interfaces than a feed has room for, or a
/// text that is too long for an address.
[[nodiscard]] Result<snapshot::FeedDescription> describe_for_feed(const LineConfig& config);

/// Returns the cycles that a feed holds: a quarter of a second, as far as that fits into 16 MiB.
[[nodiscard]] std::uint64_t feed_cycles(const LineConfig& config) noexcept;

/// Sets state, figures and the newest faults of the line in `record`; its other fields stay unchanged.
void set_status(snapshot::FeedStatus& record, const snapshot::LineStatus& status);

}  // namespace driveline::runtime
