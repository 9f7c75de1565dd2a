#pragma once

#include <vector>

#include "driveline/ecat_master/dc/system_time.hpp"

namespace driveline::ecat_master::dc {

/// A frame that met the reference clock.
struct ClockSample {
  std::chrono::nanoseconds sent{0};   ///< send time on the master's clock
  std::chrono::nanoseconds ahead{0};  ///< reference clock minus mapping when the frame met it
};

/// Estimates the frequency of the reference clock relative to the master's from frames of which many were delayed: the
/// thread may be preempted after reading the master's clock, and the frame may wait in queues.
///
/// First fits a line that outliers cannot move (the median of the slopes between the two halves of the frames, the
/// median of the remainders), then a least-squares line through the frames near it. Tolerates almost half of all frames
/// being wrong. Allocates.
class MappingFit {
 public:
  /// Samples in order of time.
  void add(const ClockSample& sample) { samples_.push_back(sample); }
  /// Number of samples so far.
  [[nodiscard]] std::size_t size() const noexcept { return samples_.size(); }

  /// Moves `mapping` to the time of the last sample and corrects its frequency, limited to PhaseController::kMaxPpm.
  /// With fewer than two samples only moves it.
  void apply(ClockMapping& mapping) const;

 private:
  std::vector<ClockSample> samples_;
};

}  // namespace driveline::ecat_master::dc
