#pragma once

#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/snapshot.hpp"

/// From the records of the house to the types of the IDL.
namespace driveline::bridge {

/// A message for one axis with all that never changes filled in.
[[nodiscard]] telemetry::AxisTelemetry axis_message(std::uint16_t axis, const AxisInfo& info);

/// Fills in what a sample says; leaves the identity of the axis alone.
void set_sample(telemetry::AxisTelemetry& message, const snapshot::AxisSample& sample);

/// Fills in what the owner of the line says.
void set_status(telemetry::LineStatus& message, const snapshot::LineStatus& status);

/// Fills in what the newest cycle says.
void set_cycle(telemetry::LineStatus& message, const snapshot::LineSample& sample);

}  // namespace driveline::bridge
