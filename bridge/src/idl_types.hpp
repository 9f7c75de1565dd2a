#pragma once

#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
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

}  // namespace driveline::bridge
