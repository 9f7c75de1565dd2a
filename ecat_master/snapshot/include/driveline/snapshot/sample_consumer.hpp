#pragma once

#include <cstdint>
#include <span>

#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::snapshot {

/// Samples that went through the telemetry rings since the start.
struct DrainCounters {
  std::uint64_t lines = 0;          ///< line samples handed to the consumers
  std::uint64_t axes = 0;           ///< axis samples handed to the consumers
  std::uint64_t lines_dropped = 0;  ///< line samples lost because the ring was full
  std::uint64_t axes_dropped = 0;   ///< axis samples lost because the ring was full
};

/// Receives every sample of the cycle: a DDS publisher, a recorder, a plot.
///
/// All functions but set_line_status() are called by the thread of a DrainThread, never by the real-time thread, so
/// they may allocate, lock and write files. A slow or blocking consumer costs samples (the rings fill up, and drops are
/// counted) but never delays the cycle. An exception that leaves a consumer ends the process.
class SampleConsumer {
 public:
  virtual ~SampleConsumer() = default;

  /// The next line samples, oldest first, in a buffer that is reused after the call.
  virtual void lines(std::span<const LineSample> samples) = 0;

  /// The next axis samples, oldest first, in the order the cycle wrote them, in a buffer that is reused after the call.
  virtual void axes(std::span<const AxisSample> samples) = 0;

  /// Called when state, faults or figures of the line have changed. Called on any thread but the real-time thread, also
  /// while another function of the consumer runs.
  virtual void set_line_status(const LineStatus& /*status*/) {}

  /// End of a pass over the rings, at least once per drain period even when nothing arrived. Place periodic work here.
  virtual void pass_done(const DrainCounters& /*counters*/) {}

  /// The last call: the rings are drained and the thread ends afterwards.
  virtual void finish(const DrainCounters& /*counters*/) {}

 protected:
  SampleConsumer() = default;
  /// Copying is for implementations only: consumers are used by reference.
  SampleConsumer(const SampleConsumer&) = default;
  SampleConsumer& operator=(const SampleConsumer&) = default;
};

}  // namespace driveline::snapshot
