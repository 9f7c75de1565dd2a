#include "idl_types.hpp"

#include <cstdint>
#include <utility>
#include <vector>

namespace driveline::bridge {
namespace {

// The enumerations are cast, not mapped: both sides list the same states in the same order.
template <class Here, class OnTheWire>
constexpr bool same(Here here, OnTheWire on_the_wire) {
  return static_cast<std::uint32_t>(here) == static_cast<std::uint32_t>(on_the_wire);
}
using snapshot::AxisState;
static_assert(same(AxisState::kNotReadyToSwitchOn, telemetry::AXIS_NOT_READY_TO_SWITCH_ON));
static_assert(same(AxisState::kSwitchOnDisabled, telemetry::AXIS_SWITCH_ON_DISABLED));
static_assert(same(AxisState::kReadyToSwitchOn, telemetry::AXIS_READY_TO_SWITCH_ON));
static_assert(same(AxisState::kSwitchedOn, telemetry::AXIS_SWITCHED_ON));
static_assert(same(AxisState::kOperationEnabled, telemetry::AXIS_OPERATION_ENABLED));
static_assert(same(AxisState::kQuickStopActive, telemetry::AXIS_QUICK_STOP_ACTIVE));
static_assert(same(AxisState::kFaultReactionActive, telemetry::AXIS_FAULT_REACTION_ACTIVE));
static_assert(same(AxisState::kFault, telemetry::AXIS_FAULT));
static_assert(same(AxisState::kUnavailable, telemetry::AXIS_UNAVAILABLE));
static_assert(same(AxisKind::kRotary, telemetry::AXIS_ROTARY));
static_assert(same(AxisKind::kLinear, telemetry::AXIS_LINEAR));
static_assert(same(snapshot::LineState::kDown, telemetry::LINE_DOWN));
static_assert(same(snapshot::LineState::kInit, telemetry::LINE_INIT));
static_assert(same(snapshot::LineState::kPreOp, telemetry::LINE_PRE_OP));
static_assert(same(snapshot::LineState::kSafeOp, telemetry::LINE_SAFE_OP));
static_assert(same(snapshot::LineState::kOp, telemetry::LINE_OP));

constexpr std::size_t kMaxFaults = 16;  ///< bound of LineStatus::faults in the IDL

telemetry::Percentiles percentiles(const snapshot::Percentiles& from) {
  telemetry::Percentiles to;
  to.p50_ns(from.p50.count());
  to.p99_ns(from.p99.count());
  to.max_ns(from.max.count());
  return to;
}

}  // namespace

telemetry::AxisTelemetry axis_message(std::uint16_t axis, const AxisInfo& info) {
  telemetry::AxisTelemetry message;
  message.axis(axis);
  message.name(info.name.c_str());
  message.kind(static_cast<telemetry::AxisKind>(info.kind));
  return message;
}

void set_sample(telemetry::AxisTelemetry& message, const snapshot::AxisSample& sample) {
  message.cycle(sample.cycle);
  message.time_ns(sample.time_ns);
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

void set_status(telemetry::LineStatus& message, const snapshot::LineStatus& status) {
  message.state(static_cast<telemetry::LineState>(status.state));
  message.cycle_period_ns(status.cycle_period.count());
  message.cycles(status.cycles);
  message.missed_periods(status.missed_periods);
  message.wkc_errors(status.wkc_errors);
  message.lost_frames(status.lost_frames);
  message.wake_latency(percentiles(status.wake_latency));
  message.cycle_cost(percentiles(status.cycle_cost));
  const std::size_t skipped = status.faults.size() > kMaxFaults ? status.faults.size() - kMaxFaults : 0;
  message.faults().clear();
  for (std::size_t i = skipped; i < status.faults.size(); ++i) {
    message.faults().emplace_back(status.faults[i].c_str());
  }
}

void set_cycle(telemetry::LineStatus& message, const snapshot::LineSample& sample) {
  message.cycle(sample.cycle);
  message.time_ns(sample.time_ns);
  message.dc_locked(sample.dc_locked);
  message.dc_difference_ns(sample.dc_difference_ns);
}

}  // namespace driveline::bridge
