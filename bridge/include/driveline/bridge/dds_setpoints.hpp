#pragma once

#include <cstddef>
#include <memory>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/bridge/dds_error.hpp"
#include "driveline/snapshot/feed/setpoint_records.hpp"

namespace driveline::bridge {

class DdsPublisher;

/// Name of the DDS topic of setpoints.
inline constexpr const char* kSetpointTopic = "driveline/v1/setpoints";
/// Name of the DDS topic that tells how streams go on.
inline constexpr const char* kStreamStatusTopic = "driveline/v1/stream_status";

/// Streams of setpoints over DDS (bridge/idl/commands.idl). Nothing is checked here but that no client takes the room
/// of others.
///
/// Belongs to one thread.
class DdsSetpoints {
 public:
  /// Setpoints of one participant that are handed on in a second, and at once: one in each cycle of 125 us. What is
  /// beyond is dropped.
  static constexpr double kParticipantRate = 8000.0;
  static constexpr double kParticipantAtOnce = 1000.0;

  /// Reads and reports in the domain of `publisher`, which must outlive it.
  [[nodiscard]] static tl::expected<std::unique_ptr<DdsSetpoints>, DdsError> create(DdsPublisher& publisher);
  ~DdsSetpoints();
  DdsSetpoints(const DdsSetpoints&) = delete;
  DdsSetpoints& operator=(const DdsSetpoints&) = delete;

  /// The next batch, setpoint by setpoint, in the place of what was in `setpoints`. False: there is none just now.
  [[nodiscard]] bool take(std::vector<snapshot::StreamedSetpoint>& setpoints);
  /// Publishes how a stream goes on.
  void report(const snapshot::StreamReport& report);

 private:
  struct State;
  explicit DdsSetpoints(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace driveline::bridge
