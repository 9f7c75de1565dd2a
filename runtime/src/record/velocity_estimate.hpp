#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "driveline/snapshot/sample_consumer.hpp"

namespace driveline::runtime {

/// Completes the samples of axes whose drives do not report their velocity, on their way to the consumers: it is the
/// change of the position since the sample before. PDOs on a CAN bus have no room for 606Ch beside what each SYNC
/// needs.
///
/// Used by the thread of a DrainThread, except estimate().
class VelocityEstimate final : public snapshot::SampleConsumer {
 public:
  /// `consumers` must outlive it.
  explicit VelocityEstimate(std::vector<snapshot::SampleConsumer*> consumers);

  /// Sets the axes without a reported velocity, by number, with the highest velocity of each, rad/s or m/s; 0: its
  /// drive reports it. To be called before the cycle starts.
  void estimate(const std::vector<double>& highest);

  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void pass_done(const snapshot::DrainCounters& counters) override;
  void finish(const snapshot::DrainCounters& counters) override;

 private:
  /// An axis, and its sample before.
  struct Axis {
    double highest = 0.0;  ///< 0: the drive reports the velocity
    bool known = false;
    std::int64_t time_ns = 0;
    double position = 0.0;
    double velocity = 0.0;
  };
  void complete(snapshot::AxisSample& sample);

  std::vector<snapshot::SampleConsumer*> consumers_;
  std::vector<Axis> axes_;  ///< empty: every drive reports its velocity
  std::vector<snapshot::AxisSample> completed_;
};

}  // namespace driveline::runtime
