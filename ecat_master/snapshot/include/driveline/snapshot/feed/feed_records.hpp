#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "driveline/rt/shared_block.hpp"
#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/snapshot/feed/feed_topic.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/snapshot.hpp"

/// What a process that holds a line provides to other processes on this machine, in shared memory: a constant
/// description of the line, a record for every cycle, the status of the line, and its events. Readers map it read-only.
/// The bridge to DDS sends its counters back in a separate region, FeedReturn.
///
/// Every bit pattern is a valid value of these records; the reader checks the values that matter.
namespace driveline::snapshot {

/// Most axes in a feed.
inline constexpr std::size_t kMaxFeedAxes = 512;
/// Most network interfaces listed in a feed.
inline constexpr std::size_t kMaxFeedInterfaces = 16;
/// Most machines to which a line announces itself by unicast.
inline constexpr std::size_t kMaxFeedPeers = 16;
/// Most faults in a status.
inline constexpr std::size_t kMaxFeedFaults = 16;
/// Number of events stored in a feed.
inline constexpr std::size_t kFeedEvents = 64;

/// A text of at most kBytes bytes; a longer one is cut off.
template <std::size_t kBytes>
struct FeedText {
  std::array<char, kBytes + 1> bytes{};  ///< text up to the first 0

  /// Stores `text`, truncated to kBytes.
  void set(std::string_view text) noexcept {
    bytes = {};
    std::copy_n(text.begin(), std::min(text.size(), kBytes), bytes.begin());
  }
  /// The text up to the first 0, or all bytes.
  [[nodiscard]] std::string_view view() const noexcept {
    const auto end = std::find(bytes.begin(), bytes.end(), '\0');
    return {bytes.data(), static_cast<std::size_t>(end - bytes.begin())};
  }
};

/// An axis of the line.
struct FeedAxis {
  FeedText<31> name;         ///< as configured
  std::uint64_t linear = 0;  ///< 0: rad, rad/s, Nm; else m, m/s, N
};

/// How often a topic is published.
struct FeedRate {
  FeedRateKind kind = FeedRateKind::kDefault;  ///< selects which of the next two members is used, if any
  std::uint32_t cycles = 1;                    ///< kCycles: every n-th cycle
  std::int64_t period_ns = 0;                  ///< kPeriod: publishing interval
};

/// The part of a feed that does not change while the line runs.
struct FeedDescription {
  FeedText<31> line;                 ///< name of the line
  std::uint32_t axes = 0;            ///< number of axes, up to kMaxFeedAxes
  std::uint32_t domain = 0;          ///< DDS domain
  std::uint32_t decimation = 1;      ///< axis samples of every n-th cycle are published
  std::uint32_t interfaces = 0;      ///< number of `interface` addresses; 0: every interface
  std::int32_t realtime_cpu = -1;    ///< CPU of the cycle, which other threads must avoid; -1: none
  std::uint32_t virtual_time = 0;    ///< not 0: the line runs on virtual time, not on the machine's time
  std::uint32_t ros2 = 0;            ///< not 0: also publishes joint states for ROS 2
  std::uint32_t shared_memory = 0;   ///< not 0: also publishes through shared memory, to readers of the bridge's user
  std::uint32_t slaves = 0;          ///< number of slaves that the condition has room for
  std::uint32_t reserved = 0;        ///< 0
  std::int64_t period_ns = 0;        ///< period of the cycle
  std::uint32_t peers = 0;           ///< number of `peer` addresses
  std::uint32_t discovery_port = 0;  ///< port of the discovery server; 0: none
  FeedText<47> discovery_server;     ///< IPv4 address of the discovery server
  FeedText<63> partition;            ///< DDS partition; empty: the default one
  std::array<FeedRate, kFeedTopics> rate;                  ///< by FeedTopic
  std::array<FeedText<47>, kMaxFeedPeers> peer;            ///< IPv4 addresses of other machines
  std::array<FeedText<47>, kMaxFeedInterfaces> interface;  ///< IPv4 addresses
  std::array<FeedAxis, kMaxFeedAxes> axis;                 ///< by index
};

/// LineSample without the type `bool`. The record of a cycle starts with it.
struct FeedLine {
  std::uint64_t cycle = 0;                     ///< LineSample::cycle
  std::int64_t time_ns = 0;                    ///< LineSample::time_ns
  std::int64_t wake_latency_ns = 0;            ///< LineSample::wake_latency_ns
  std::int64_t cost_ns = 0;                    ///< LineSample::cost_ns
  std::int64_t round_trip_ns = 0;              ///< LineSample::round_trip_ns
  std::int64_t dc_difference_ns = 0;           ///< LineSample::dc_difference_ns
  std::uint32_t missed_periods = 0;            ///< LineSample::missed_periods
  std::uint16_t working_counter = 0;           ///< LineSample::working_counter
  std::uint16_t expected_working_counter = 0;  ///< LineSample::expected_working_counter
  std::uint16_t axes = 0;                      ///< number of FeedAxisSample records that follow in this record
  std::uint8_t frame_received = 0;             ///< LineSample::frame_received
  std::uint8_t dc_locked = 0;                  ///< LineSample::dc_locked
  std::uint8_t present = 0;             ///< 0: the cycle's line sample was lost; only `cycle` and the axes are valid
  std::uint8_t bus_send_errors = 0;     ///< LineSample::bus_send_errors
  std::uint8_t bus_receive_errors = 0;  ///< LineSample::bus_receive_errors
  std::uint8_t reserved = 0;            ///< 0
  float bus_load = 0.0F;                ///< LineSample::bus_load
  std::uint32_t reserved_end = 0;       ///< 0
};

/// AxisSample in the record of its cycle.
struct FeedAxisSample {
  std::int64_t time_ns = 0;          ///< AxisSample::time_ns
  std::uint16_t axis = 0;            ///< AxisSample::axis
  std::uint16_t control_word = 0;    ///< AxisSample::control_word
  std::uint16_t status_word = 0;     ///< AxisSample::status_word
  std::int8_t mode = 0;              ///< AxisSample::mode
  std::uint8_t state = 0;            ///< AxisSample::state
  std::uint8_t plcopen_state = 0;    ///< AxisSample::plcopen_state
  std::uint8_t homed = 0;            ///< AxisSample::homed
  std::uint16_t error_code = 0;      ///< AxisSample::error_code
  std::uint32_t reserved = 0;        ///< 0
  std::int64_t digital_inputs = 0;   ///< AxisSample::digital_inputs
  double target_position = 0;        ///< AxisSample::target_position
  double actual_position = 0;        ///< AxisSample::actual_position
  double target_velocity = 0;        ///< AxisSample::target_velocity
  double actual_velocity = 0;        ///< AxisSample::actual_velocity
  double target_torque = 0;          ///< AxisSample::target_torque
  double actual_torque = 0;          ///< AxisSample::actual_torque
  double following_error = 0;        ///< AxisSample::following_error
  double drive_following_error = 0;  ///< AxisSample::drive_following_error
  double demand_position = 0;        ///< AxisSample::demand_position
  double demand_velocity = 0;        ///< AxisSample::demand_velocity
  double demand_torque = 0;          ///< AxisSample::demand_torque
};

/// LineStatus, and the state of the feed.
struct FeedStatus {
  std::uint8_t state = 0;                           ///< LineStatus::state
  std::uint8_t ended = 0;                           ///< not 0: the feed has ended
  std::uint16_t faults = 0;                         ///< number of valid `fault` entries, up to kMaxFeedFaults
  std::uint32_t restarts = 0;                       ///< restarts of the bridge
  std::uint64_t cycles = 0;                         ///< LineStatus::cycles
  std::uint64_t missed_periods = 0;                 ///< LineStatus::missed_periods
  std::uint64_t wkc_errors = 0;                     ///< LineStatus::wkc_errors
  std::uint64_t lost_frames = 0;                    ///< LineStatus::lost_frames
  std::array<std::int64_t, 3> wake_latency_ns{};    ///< median, 99th percentile, largest
  std::array<std::int64_t, 3> cycle_cost_ns{};      ///< median, 99th percentile, largest
  std::uint64_t published_before = 0;               ///< axis samples published by previous bridges
  std::uint64_t dropped_before = 0;                 ///< samples lost before the feed or by previous bridges
  std::uint64_t beats = 0;                          ///< number of status updates; constant when the process hangs
  CycleStatisticsSample statistics;                 ///< LineStatus::statistics
  std::array<FeedText<255>, kMaxFeedFaults> fault;  ///< oldest first
};

/// An event of the line. Its number is that of the record, starting at 0.
struct FeedEvent {
  std::int64_t wall_time_ns = 0;  ///< since 1970-01-01 UTC
  std::uint64_t severity = 0;     ///< 0: a step of the run, 1: a notice, 2: a fault, 3: a failure
  FeedText<511> text;             ///< one sentence
};

/// What the bridge sends back: one record that only the bridge writes. The line's process must not trust it unchecked.
struct FeedReturn {
  std::uint64_t beats = 0;      ///< passes over the feed; constant when the bridge hangs
  std::uint64_t next = 0;       ///< number of the cycle record that the bridge takes next
  std::uint64_t published = 0;  ///< axis samples handed to DDS
  std::uint64_t lost = 0;       ///< records that were overwritten before the bridge took them
  std::uint64_t refused = 0;    ///< axis samples refused by DDS
};

/// Content numbers of the regions, and the version of all of them.
inline constexpr std::uint32_t kFeedVersion = 5;
inline constexpr std::uint32_t kFeedDescriptionContent = 0x4644'4553;  ///< FeedDescription
inline constexpr std::uint32_t kFeedStatusContent = 0x4653'5441;       ///< FeedStatus
inline constexpr std::uint32_t kFeedCyclesContent = 0x4643'5943;       ///< FeedLine with its FeedAxisSample
inline constexpr std::uint32_t kFeedEventsContent = 0x4645'564E;       ///< FeedEvent
inline constexpr std::uint32_t kFeedReturnContent = 0x4652'4554;       ///< FeedReturn

/// Offset of axis sample number `index` in the record of a cycle, in bytes.
[[nodiscard]] constexpr std::size_t feed_axis_offset(std::size_t index) noexcept {
  return sizeof(FeedLine) + index * sizeof(FeedAxisSample);
}
static_assert(sizeof(FeedLine) % sizeof(std::uint64_t) == 0 && sizeof(FeedAxisSample) % sizeof(std::uint64_t) == 0);

/// \name Layouts of the regions
/// @{

/// Layout of the description.
[[nodiscard]] constexpr rt::SharedLayout feed_description_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_broadcast<FeedDescription>(kFeedDescriptionContent, kFeedVersion, capacity);
}
/// Layout of the status.
[[nodiscard]] constexpr rt::SharedLayout feed_status_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_broadcast<FeedStatus>(kFeedStatusContent, kFeedVersion, capacity);
}
/// Layout of the cycles of a line with `axes` axes.
[[nodiscard]] constexpr rt::SharedLayout feed_cycles_layout(std::size_t axes, std::uint64_t capacity = 0) noexcept {
  return rt::shared_blocks(kFeedCyclesContent, kFeedVersion, static_cast<std::uint32_t>(feed_axis_offset(axes)),
                           capacity);
}
/// Layout of the events.
[[nodiscard]] constexpr rt::SharedLayout feed_events_layout(std::uint64_t capacity = 0) noexcept {
  return rt::shared_blocks(kFeedEventsContent, kFeedVersion, sizeof(FeedEvent), capacity);
}
/// Layout of the counters sent back by the bridge; the line's process can write it, too.
[[nodiscard]] constexpr rt::SharedLayout feed_return_layout(std::uint64_t capacity = 0) noexcept {
  return {rt::SharedForm::kRing, kFeedReturnContent, kFeedVersion, sizeof(FeedReturn), capacity};
}
/// @}

///
/// ame Conversion between samples and feed records
/// @{

/// Sets `present`; FeedWriter::push() sets the number of axes.
[[nodiscard]] inline FeedLine to_feed(const LineSample& sample) noexcept {
  FeedLine line;
  line.cycle = sample.cycle;
  line.time_ns = sample.time_ns;
  line.wake_latency_ns = sample.wake_latency_ns;
  line.cost_ns = sample.cost_ns;
  line.round_trip_ns = sample.round_trip_ns;
  line.dc_difference_ns = sample.dc_difference_ns;
  line.missed_periods = sample.missed_periods;
  line.working_counter = sample.working_counter;
  line.expected_working_counter = sample.expected_working_counter;
  line.frame_received = sample.frame_received ? 1 : 0;
  line.dc_locked = sample.dc_locked ? 1 : 0;
  line.present = 1;
  line.bus_send_errors = sample.bus_send_errors;
  line.bus_receive_errors = sample.bus_receive_errors;
  line.bus_load = sample.bus_load;
  return line;
}
/// Omits the cycle number, which is in the FeedLine of the record.
[[nodiscard]] inline FeedAxisSample to_feed(const AxisSample& sample) noexcept {
  return {.time_ns = sample.time_ns,
          .axis = sample.axis,
          .control_word = sample.control_word,
          .status_word = sample.status_word,
          .mode = sample.mode,
          .state = static_cast<std::uint8_t>(sample.state),
          .plcopen_state = static_cast<std::uint8_t>(sample.plcopen_state),
          .homed = static_cast<std::uint8_t>(sample.homed),
          .error_code = sample.error_code,
          .reserved = 0,
          .digital_inputs = sample.digital_inputs,
          .target_position = sample.target_position,
          .actual_position = sample.actual_position,
          .target_velocity = sample.target_velocity,
          .actual_velocity = sample.actual_velocity,
          .target_torque = sample.target_torque,
          .actual_torque = sample.actual_torque,
          .following_error = sample.following_error,
          .drive_following_error = sample.drive_following_error,
          .demand_position = sample.demand_position,
          .demand_velocity = sample.demand_velocity,
          .demand_torque = sample.demand_torque};
}
/// `axes`: number of axis samples of the cycle.
[[nodiscard]] inline LineSample from_feed(const FeedLine& line, std::uint16_t axes) noexcept {
  return {.cycle = line.cycle,
          .time_ns = line.time_ns,
          .wake_latency_ns = line.wake_latency_ns,
          .cost_ns = line.cost_ns,
          .round_trip_ns = line.round_trip_ns,
          .dc_difference_ns = line.dc_difference_ns,
          .missed_periods = line.missed_periods,
          .working_counter = line.working_counter,
          .expected_working_counter = line.expected_working_counter,
          .axes = axes,
          .frame_received = line.frame_received != 0,
          .dc_locked = line.dc_locked != 0,
          .bus_load = line.bus_load,
          .bus_send_errors = line.bus_send_errors,
          .bus_receive_errors = line.bus_receive_errors};
}
/// An invalid state becomes AxisState::kUnavailable, SampledPlcopenState::kNone or AxisHomed::kUnknown.
[[nodiscard]] inline AxisSample from_feed(const FeedAxisSample& sample, std::uint64_t cycle) noexcept {
  const bool known = sample.state <= static_cast<std::uint8_t>(AxisState::kUnavailable);
  const bool plcopen = sample.plcopen_state <= static_cast<std::uint8_t>(SampledPlcopenState::kErrorStop);
  const bool homed = sample.homed <= static_cast<std::uint8_t>(AxisHomed::kYes);
  return {
      .cycle = cycle,
      .time_ns = sample.time_ns,
      .axis = sample.axis,
      .control_word = sample.control_word,
      .status_word = sample.status_word,
      .mode = sample.mode,
      .state = known ? static_cast<AxisState>(sample.state) : AxisState::kUnavailable,
      .plcopen_state = plcopen ? static_cast<SampledPlcopenState>(sample.plcopen_state) : SampledPlcopenState::kNone,
      .homed = homed ? static_cast<AxisHomed>(sample.homed) : AxisHomed::kUnknown,
      .error_code = sample.error_code,
      .reserved = 0,
      .digital_inputs = sample.digital_inputs,
      .target_position = sample.target_position,
      .actual_position = sample.actual_position,
      .target_velocity = sample.target_velocity,
      .actual_velocity = sample.actual_velocity,
      .target_torque = sample.target_torque,
      .actual_torque = sample.actual_torque,
      .following_error = sample.following_error,
      .drive_following_error = sample.drive_following_error,
      .demand_position = sample.demand_position,
      .demand_velocity = sample.demand_velocity,
      .demand_torque = sample.demand_torque};
}
/// @}

}  // namespace driveline::snapshot
