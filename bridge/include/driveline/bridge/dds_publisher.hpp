#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/bridge/dds_error.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/sample_consumer.hpp"

namespace eprosima::fastdds::dds {
class DomainParticipant;
}

namespace driveline::bridge {

/// Counters of the telemetry.
struct PublishCounters {
  std::uint64_t published = 0;  ///< axis samples passed to DDS
  /// Samples lost before DDS: dropped by a full ring (even if their cycle would not have been published), of an axis
  /// that is not configured, or refused by DDS.
  std::uint64_t dropped = 0;
};

/// Severity of a DdsEvent.
enum class DdsEventSeverity : std::uint8_t { kProgress, kNotice, kFault, kFailure };

/// An event on the line.
struct DdsEvent {
  std::uint64_t number = 0;                               ///< number of the event, from 0
  std::int64_t wall_time_ns = 0;                          ///< since 1970-01-01 UTC
  DdsEventSeverity severity = DdsEventSeverity::kNotice;  ///< severity of the event
  std::string text;                                       ///< one sentence; up to 511 bytes of it are published
};

/// Publishes a line over DDS: one instance of AxisTelemetry per axis and the LineStatus (bridge/idl/driveline.idl).
///
/// Axis telemetry is best effort and stores the last samples; line status is reliable and transient local, so that a
/// late subscriber receives the newest one. A DrainThread feeds the publisher; nothing here is real-time safe.
class DdsPublisher final : public snapshot::SampleConsumer {
 public:
  /// Checks the configuration, joins the domain and creates the writers. Fast DDS starts its own threads here, which
  /// inherit scheduling and CPU affinity of the caller, so do not call it from the real-time thread. From here on Fast
  /// DDS logs to stderr, process-wide (its default is stdout).
  [[nodiscard]] static tl::expected<std::unique_ptr<DdsPublisher>, DdsError> create(DdsConfig config);
  /// Leaves the domain.
  ~DdsPublisher() override;
  DdsPublisher(const DdsPublisher&) = delete;
  DdsPublisher& operator=(const DdsPublisher&) = delete;

  /// Sets the status to publish from now on; a change of state or faults is published with the next pass of the drain
  /// thread, anything else with the next period. Any thread except the real-time one (it locks).
  void set_line_status(const snapshot::LineStatus& status) override;

  /// The DDS participant of this publisher.
  [[nodiscard]] eprosima::fastdds::dds::DomainParticipant& participant() noexcept;
  /// The DDS partition of this publisher; empty: the default partition.
  [[nodiscard]] const std::string& partition() const noexcept;

  /// Counters of this publisher. Any thread.
  [[nodiscard]] PublishCounters counters() const noexcept;

  /// Publishes an event; the last 64 reach late subscribers. On the thread of the samples.
  void event(const DdsEvent& event);

  /// Sets the condition of the slaves and the owners of the axes; changes are published. On the thread of the samples.
  void set_condition(const snapshot::FeedCondition& condition);

  /// Sets whether the line has stalled: its state is unknown, although its end was not reported. Then no line status is
  /// published, so that deadline and liveliness notify subscribers. On the thread of the samples.
  void set_stalled(bool stalled);

  /// Sets the counters of earlier publishers of the same line; the line status adds its own to them. Any thread except
  /// the real-time one (it locks).
  void set_earlier(const PublishCounters& counters);

  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void pass_done(const snapshot::DrainCounters& counters) override;
  /// Publishes the last status and waits briefly until its subscribers have received it.
  void finish(const snapshot::DrainCounters& counters) override;

 private:
  struct State;
  explicit DdsPublisher(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace driveline::bridge
