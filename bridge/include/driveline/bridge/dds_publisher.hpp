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
  std::uint64_t published = 0;  ///< axis samples handed to DDS
  /// Samples that got lost before DDS: dropped by a full ring (whether their cycle would have been published or not),
  /// of an axis that is not configured, or refused by DDS.
  std::uint64_t dropped = 0;
};

/// How grave a DdsEvent is.
enum class DdsEventSeverity : std::uint8_t { kProgress, kNotice, kFault, kFailure };

/// Something that has happened to the line.
struct DdsEvent {
  std::uint64_t number = 0;                               ///< of the event, from 0
  std::int64_t wall_time_ns = 0;                          ///< since 1970-01-01 UTC
  DdsEventSeverity severity = DdsEventSeverity::kNotice;  ///< how grave it is
  std::string text;                                       ///< one sentence; up to 511 bytes of it are published
};

/// Publishes a line over DDS: one instance of AxisTelemetry per axis and the LineStatus (bridge/idl/driveline.idl).
///
/// Axis telemetry is best effort and keeps the last samples; line status is reliable and transient local, so a late
/// subscriber gets the newest one. The publisher is fed by a DrainThread; nothing here is real-time safe.
class DdsPublisher final : public snapshot::SampleConsumer {
 public:
  /// Checks the configuration, joins the domain and creates the writers. Fast DDS starts its own threads here; they
  /// inherit scheduling and CPU affinity of the caller, so do not call it from the real-time thread. From here on Fast
  /// DDS logs to stderr, process-wide (its default is stdout).
  [[nodiscard]] static tl::expected<std::unique_ptr<DdsPublisher>, DdsError> create(DdsConfig config);
  /// Leaves the domain.
  ~DdsPublisher() override;
  DdsPublisher(const DdsPublisher&) = delete;
  DdsPublisher& operator=(const DdsPublisher&) = delete;

  /// The status to publish from now on; a change of state or faults goes out with the next pass of the drain thread,
  /// anything else with the next period. Any thread but the real-time one (it locks).
  void set_line_status(const snapshot::LineStatus& status) override;

  /// In which it publishes.
  [[nodiscard]] eprosima::fastdds::dds::DomainParticipant& participant() noexcept;
  /// In which it publishes; empty: the default one.
  [[nodiscard]] const std::string& partition() const noexcept;

  /// Of this publisher. Any thread.
  [[nodiscard]] PublishCounters counters() const noexcept;

  /// Publishes an event; the last 64 reach late subscribers. On the thread of the samples.
  void event(const DdsEvent& event);

  /// What is known of the slaves and of who commands the axes: what has changed is published. On the thread of the
  /// samples.
  void set_condition(const snapshot::FeedCondition& condition);

  /// Nothing is known of the line any more, though nobody has said that it has ended: no line status is published, so
  /// that its deadline and its liveliness tell subscribers. On the thread of the samples.
  void set_stalled(bool stalled);

  /// Counters of publishers of the same line before this one, to which the line status adds its own. Any thread but the
  /// real-time one (it locks).
  void set_earlier(const PublishCounters& counters);

  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void pass_done(const snapshot::DrainCounters& counters) override;
  /// Publishes the last status and waits briefly for its subscribers to have it.
  void finish(const snapshot::DrainCounters& counters) override;

 private:
  struct State;
  explicit DdsPublisher(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace driveline::bridge
