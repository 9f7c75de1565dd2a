#pragma once

#include <cstddef>
#include <cstdint>

#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/snapshot.hpp"

/// Conversion of snapshot records to the types of the IDL.
namespace driveline::bridge {

/// A message for one axis with all that never changes filled in.
[[nodiscard]] telemetry::AxisTelemetry axis_message(std::uint16_t axis, const AxisInfo& info);

/// Fills in the values of a sample; leaves the identity of the axis as it is.
void set_sample(telemetry::AxisTelemetry& message, const snapshot::AxisSample& sample);

/// Fills in state, figures and faults of the line.
void set_status(telemetry::LineStatus& message, const snapshot::LineStatus& status);

/// Fills in the values of the newest cycle.
void set_cycle(telemetry::LineStatus& message, const snapshot::LineSample& sample);

/// Statistics of a cycle of that period.
[[nodiscard]] telemetry::CycleStatistics statistics_message(const snapshot::CycleStatistics& statistics,
                                                            std::int64_t period_ns);

/// Slave number `position`.
[[nodiscard]] telemetry::Slave slave_message(const snapshot::FeedSlave& slave, std::size_t position);

/// How the slaves hang together.
[[nodiscard]] telemetry::Topology topology_message(const snapshot::FeedCondition& condition);

}  // namespace driveline::bridge
