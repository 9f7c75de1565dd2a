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

/// Publishes what the axes do, each when that has changed: as it is at the end of a pass, because an axis may change in
/// every cycle. Digital inputs alone are published less often.
class AxisStates {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `entities` must outlive it.
  AxisStates(const DdsConfig& config, DdsEntities& entities);

  /// The next sample of an axis.
  void add(const snapshot::AxisSample& sample) {
    if (sample.axis < axes_.size()) {
      axes_[sample.axis].newest = sample;
      axes_[sample.axis].seen = true;
    }
  }
  /// Who commands the axes.
  void set_owners(const std::vector<snapshot::FeedOwner>& owners);
  /// By the clock of the machine, minus the master's clock; for the samples that follow.
  void set_wall_offset(std::int64_t offset_ns) noexcept { wall_offset_ns_ = offset_ns; }
  /// Publishes what has changed.
  void publish(Time now);

 private:
  struct Axis {
    snapshot::AxisSample newest;
    std::string owner;
    bool seen = false;  ///< there is a sample
    bool told = false;  ///< `message` was published
    Time at;            ///< when
    telemetry::AxisStatus message;
  };

  [[nodiscard]] bool due(const Axis& axis, Time now) const;

  std::chrono::nanoseconds input_period_;
  DdsEntities& entities_;
  std::int64_t wall_offset_ns_ = 0;
  std::vector<Axis> axes_;
};

}  // namespace driveline::bridge
