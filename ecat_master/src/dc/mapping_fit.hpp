#pragma once

#include <vector>

#include "driveline/ecat_master/dc/system_time.hpp"

namespace driveline::ecat_master::dc {

/// One frame that met the reference clock.
struct ClockSample {
  std::chrono::nanoseconds sent{0};   ///< on the master's clock
  std::chrono::nanoseconds ahead{0};  ///< reference clock minus mapping when the frame met it
};

/// The speed of the reference clock against the master's, out of frames of which many have been held up: after the
/// reading of the master's clock the thread may be suspended, and the frame may wait in queues.
///
/// First a line that outliers cannot move (the median of the slopes between the two halves of the frames, the median of
/// what is left), then the line of least squares through the frames near it. Half of all frames but a few may be wrong.
/// Allocates.
class MappingFit {
 public:
  /// Samples in order of time.
  void add(const ClockSample& sample) { samples_.push_back(sample); }
  /// Samples so far.
  [[nodiscard]] std::size_t size() const noexcept { return samples_.size(); }

  /// Moves `mapping` to the time of the last sample and corrects its speed, to at most PhaseController::kMaxPpm. With
  /// fewer than two samples only the former.
  void apply(ClockMapping& mapping) const;

 private:
  std::vector<ClockSample> samples_;
};

}  // namespace driveline::ecat_master::dc
