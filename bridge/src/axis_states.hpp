#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "dds_entities.hpp"
#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::bridge {

/// Publishes the states of the axes when they change: the state at the end of a pass, because an axis may change in
/// every cycle. Changes of only digital inputs are published less often.
class AxisStates {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `entities` must outlive it.
  AxisStates(const DdsConfig& config, DdsEntities& entities);

  /// Stores the next sample of an axis.
  void add(const snapshot::AxisSample& sample) {
    if (sample.axis < axes_.size()) {
      axes_[sample.axis].newest = sample;
      axes_[sample.axis].seen = true;
    }
  }
  /// Sets the owners of the axes.
  void set_owners(const std::vector<snapshot::FeedOwner>& owners);
  /// Sets the wall clock minus the master's clock, for the following samples.
  void set_wall_offset(std::int64_t offset_ns) noexcept { wall_offset_ns_ = offset_ns; }
  /// Publishes the axes that have changed.
  void publish(Time now);

 private:
  struct Axis {
    snapshot::AxisSample newest;
    std::string owner;
    bool seen = false;       ///< a sample has arrived
    bool published = false;  ///< `message` has been published
    Time at;                 ///< time of the last publication
    telemetry::AxisStatus message;
  };

  [[nodiscard]] bool due(const Axis& axis, Time now) const;

  std::chrono::nanoseconds input_period_;
  DdsEntities& entities_;
  std::int64_t wall_offset_ns_ = 0;
  std::vector<Axis> axes_;
};

}  // namespace driveline::bridge
