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
  std::uint64_t lines_dropped = 0;  ///< line samples the cycle found no room for
  std::uint64_t axes_dropped = 0;   ///< axis samples the cycle found no room for
};

/// Receives every sample of the cycle: a DDS publisher, a recorder, a plot.
///
/// All functions but set_line_status() are called by the one thread of a DrainThread, never by the real-time thread, so
/// they may allocate, lock and write files. A consumer that is slow or blocks costs samples (the rings fill up, and
/// drops are counted) but never delays the cycle. An exception that leaves a consumer ends the process.
class SampleConsumer {
 public:
  virtual ~SampleConsumer() = default;

  /// The next line samples, oldest first. They lie in a buffer that is reused after the call.
  virtual void lines(std::span<const LineSample> samples) = 0;

  /// The next axis samples, oldest first, in the order the cycle wrote them. Same buffer rule as `lines`.
  virtual void axes(std::span<const AxisSample> samples) = 0;

  /// State, faults or figures of the line have changed. Called on any thread but the real-time one, also while another
  /// function of the consumer runs.
  virtual void set_line_status(const LineStatus& /*status*/) {}

  /// End of one pass over the rings, at least once per drain period even when nothing arrived: the place for work
  /// that is due by time.
  virtual void pass_done(const DrainCounters& /*counters*/) {}

  /// Nothing follows: the rings are drained and the thread ends after this call.
  virtual void finish(const DrainCounters& /*counters*/) {}

 protected:
  SampleConsumer() = default;
  /// Copying is for implementations only: consumers are used by reference.
  SampleConsumer(const SampleConsumer&) = default;
  SampleConsumer& operator=(const SampleConsumer&) = default;
};

}  // namespace driveline::snapshot
