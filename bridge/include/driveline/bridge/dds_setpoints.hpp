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
/// Name of the DDS topic with the status of streams.
inline constexpr const char* kStreamStatusTopic = "driveline/v1/stream_status";

/// Receives streams of setpoints over DDS (bridge/idl/commands.idl). Only the rate per participant is limited, so that
/// no client uses up the capacity of others.
///
/// Belongs to one thread.
class DdsSetpoints {
 public:
  /// Setpoints of a participant that are passed on per second, and at once: one per cycle of 125 us. Further setpoints
  /// are dropped.
  static constexpr double kParticipantRate = 8000.0;
  static constexpr double kParticipantAtOnce = 1000.0;

  /// Joins the domain of `publisher`, which must outlive it.
  [[nodiscard]] static tl::expected<std::unique_ptr<DdsSetpoints>, DdsError> create(DdsPublisher& publisher);
  ~DdsSetpoints();
  DdsSetpoints(const DdsSetpoints&) = delete;
  DdsSetpoints& operator=(const DdsSetpoints&) = delete;

  /// Replaces `setpoints` by the setpoints of the next batch. Returns false if there is none at present.
  [[nodiscard]] bool take(std::vector<snapshot::StreamedSetpoint>& setpoints);
  /// Publishes the status of a stream.
  void report(const snapshot::StreamReport& report);

 private:
  struct State;
  explicit DdsSetpoints(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace driveline::bridge
