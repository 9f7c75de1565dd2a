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

/// Creates a message for one axis with all constant fields filled in.
[[nodiscard]] telemetry::AxisTelemetry axis_message(std::uint16_t axis, const AxisInfo& info);

/// Fills in the values of a sample that AxisTelemetry and AxisValues share.
template <class Message>
void set_values(Message& message, const snapshot::AxisSample& sample) {
  message.axis(sample.axis);
  message.control_word(sample.control_word);
  message.status_word(sample.status_word);
  message.mode(sample.mode);
  message.state(static_cast<telemetry::AxisState>(sample.state));
  message.target_position(sample.target_position);
  message.actual_position(sample.actual_position);
  message.target_velocity(sample.target_velocity);
  message.actual_velocity(sample.actual_velocity);
  message.target_torque(sample.target_torque);
  message.actual_torque(sample.actual_torque);
  message.following_error(sample.following_error);
}

/// Published value of object 60FDh: 0 if it is not mapped.
[[nodiscard]] inline std::uint32_t inputs_of(const snapshot::AxisSample& sample) noexcept {
  return sample.digital_inputs < 0 ? 0 : static_cast<std::uint32_t>(sample.digital_inputs);
}

/// Fills in the values of a sample; leaves the name and kind of the axis unchanged.
void set_sample(telemetry::AxisTelemetry& message, const snapshot::AxisSample& sample);

/// Fills in state, key figures and faults of the line.
void set_status(telemetry::LineStatus& message, const snapshot::LineStatus& status);

/// Fills in the values of the newest cycle.
void set_cycle(telemetry::LineStatus& message, const snapshot::LineSample& sample);

/// Creates the statistics message for a cycle of that period.
[[nodiscard]] telemetry::CycleStatistics statistics_message(const snapshot::CycleStatisticsSample& statistics,
                                                            std::int64_t period_ns);

/// Creates the message of the slave at `position`.
[[nodiscard]] telemetry::Slave slave_message(const snapshot::FeedSlave& slave, std::size_t position);

/// Creates the message of the connections between the slaves.
[[nodiscard]] telemetry::Topology topology_message(const snapshot::FeedCondition& condition);

}  // namespace driveline::bridge
