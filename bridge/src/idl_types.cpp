#include "idl_types.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace driveline::bridge {
namespace {

// Enumerations are cast, not mapped: both sides list the same states in the same order.
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
static_assert(same(snapshot::SampledPlcopenState::kNone, telemetry::PLCOPEN_NONE));
static_assert(same(snapshot::SampledPlcopenState::kDisabled, telemetry::PLCOPEN_DISABLED));
static_assert(same(snapshot::SampledPlcopenState::kStandstill, telemetry::PLCOPEN_STANDSTILL));
static_assert(same(snapshot::SampledPlcopenState::kHoming, telemetry::PLCOPEN_HOMING));
static_assert(same(snapshot::SampledPlcopenState::kStopping, telemetry::PLCOPEN_STOPPING));
static_assert(same(snapshot::SampledPlcopenState::kDiscreteMotion, telemetry::PLCOPEN_DISCRETE_MOTION));
static_assert(same(snapshot::SampledPlcopenState::kContinuousMotion, telemetry::PLCOPEN_CONTINUOUS_MOTION));
static_assert(same(snapshot::SampledPlcopenState::kSynchronizedMotion, telemetry::PLCOPEN_SYNCHRONIZED_MOTION));
static_assert(same(snapshot::SampledPlcopenState::kErrorStop, telemetry::PLCOPEN_ERROR_STOP));
static_assert(same(snapshot::AxisHomed::kUnknown, telemetry::HOMED_UNKNOWN));
static_assert(same(snapshot::AxisHomed::kNo, telemetry::HOMED_NO));
static_assert(same(snapshot::AxisHomed::kYes, telemetry::HOMED_YES));
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

telemetry::TimeDistribution distribution(const snapshot::TimeDistribution& from) {
  telemetry::TimeDistribution to;
  to.count(from.count);
  to.p50_ns(from.p50_ns);
  to.p90_ns(from.p90_ns);
  to.p99_ns(from.p99_ns);
  to.p999_ns(from.p999_ns);
  to.max_ns(from.max_ns);
  return to;
}

telemetry::CycleInterval interval(const snapshot::CycleInterval& from) {
  telemetry::CycleInterval to;
  to.duration_ns(from.duration_ns);
  to.cycles(from.cycles);
  to.missed_periods(from.missed_periods);
  to.wkc_errors(from.wkc_errors);
  to.lost_frames(from.lost_frames);
  to.wake_latency(distribution(from.wake_latency));
  to.cycle_cost(distribution(from.cost));
  to.jitter(distribution(from.jitter));
  to.round_trip(distribution(from.round_trip));
  to.dc_difference(distribution(from.dc_difference));
  return to;
}

/// AL status 0130h, bits 0 to 3 (ETG.1000.6, table of the AL states).
telemetry::SlaveState slave_state(std::uint8_t al_state) {
  switch (al_state) {
    case 1:
      return telemetry::SLAVE_INIT;
    case 2:
      return telemetry::SLAVE_PRE_OP;
    case 3:
      return telemetry::SLAVE_BOOTSTRAP;
    case 4:
      return telemetry::SLAVE_SAFE_OP;
    case 8:
      return telemetry::SLAVE_OP;
    default:
      return telemetry::SLAVE_UNKNOWN;
  }
}

telemetry::SlavePort slave_port(const snapshot::FeedSlavePort& from) {
  telemetry::SlavePort to;
  to.link(from.link != 0);
  to.open(from.open != 0);
  to.invalid_frames(from.invalid_frames);
  to.receive_errors(from.receive_errors);
  to.forwarded_errors(from.forwarded);
  to.lost_links(from.lost_links);
  return to;
}

telemetry::TopologyPort port_of(std::uint32_t slave, std::uint32_t port) {
  telemetry::TopologyPort to;
  to.position(static_cast<std::uint16_t>(slave));
  to.port(static_cast<std::uint8_t>(port % snapshot::kFeedSlavePorts));
  return to;
}

template <std::size_t kBytes>
std::string text_of(const snapshot::FeedText<kBytes>& text) {
  return std::string{text.view().substr(0, kBytes)};
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
  set_values(message, sample);
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

telemetry::CycleStatistics statistics_message(const snapshot::CycleStatisticsSample& statistics,
                                              std::int64_t period_ns) {
  telemetry::CycleStatistics message;
  message.number(statistics.number);
  message.cycle(statistics.cycle);
  message.time_ns(statistics.time_ns);
  message.wall_time_ns(statistics.wall_time_ns);
  message.cycle_period_ns(period_ns);
  message.dc_locked(statistics.dc_locked != 0);
  message.dc_difference_ns(statistics.dc_difference_ns);
  message.last(interval(statistics.last));
  message.total(interval(statistics.total));
  return message;
}

telemetry::Slave slave_message(const snapshot::FeedSlave& slave, std::size_t position) {
  telemetry::Slave message;
  message.position(static_cast<std::uint16_t>(position));
  message.name(text_of(slave.name));
  message.device(text_of(slave.device));
  message.vendor_id(slave.vendor_id);
  message.product_code(slave.product_code);
  message.revision(slave.revision);
  message.serial_number(slave.serial_number);
  message.station_address(slave.station);
  message.alias(slave.alias);
  message.hot_connect(slave.hot_connect != 0);
  message.answers(slave.answers != 0);
  message.wall_time_ns(slave.read_at_ns);
  message.state(slave_state(slave.al_state));
  message.error(slave.al_error != 0);
  message.al_status_code(slave.al_status_code);
  message.al_status_text(text_of(slave.al_text));
  for (std::size_t i = 0; i < snapshot::kFeedSlavePorts; ++i) {
    message.ports()[i] = slave_port(slave.port[i]);
  }
  message.processing_unit_errors(slave.processing_unit_errors);
  message.pdi_errors(slave.pdi_errors);
  message.dc_clock(slave.clock != 0);
  message.dc_reference(slave.clock == 2);
  message.dc_delay_ns(slave.clock_delay_ns);
  message.dc_difference_max_ns(slave.clock_difference_ns);
  message.dc_sync0_cycle_ns(slave.sync0_cycle_ns);
  return message;
}

telemetry::Topology topology_message(const snapshot::FeedCondition& condition) {
  telemetry::Topology message;
  message.slaves(static_cast<std::uint16_t>(condition.slaves.size()));
  for (std::size_t i = 0; i < condition.slaves.size(); ++i) {
    const auto& slave = condition.slaves[i];
    if (slave.parent < snapshot::kFeedParentMaster) {
      continue;
    }
    telemetry::TopologyNode node;
    node.position(static_cast<std::uint16_t>(i));
    node.parent(slave.parent);
    node.parent_port(slave.parent_port);
    node.entry_port(slave.entry_port);
    node.depth(static_cast<std::uint16_t>(slave.depth));
    message.nodes().push_back(node);
  }
  const auto& head = condition.head;
  if (head.ring_slave >= 0) {
    message.ring_end().push_back(port_of(static_cast<std::uint32_t>(head.ring_slave), head.ring_port));
  }
  for (std::uint32_t i = 0; i < head.silent_ports; ++i) {
    message.silent_ports().push_back(port_of(head.silent[i] / snapshot::kFeedSlavePorts, head.silent[i]));
  }
  return message;
}

}  // namespace driveline::bridge
