#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "dds_entities.hpp"
#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"

namespace driveline::bridge {

/// Publishes each slave of a line when it changes and periodically, and the topology when it changes.
class SlaveTopics {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `entities` must outlive it.
  SlaveTopics(const DdsConfig& config, DdsEntities& entities) : period_(config.slave_period), entities_(entities) {}

  /// Sets the present condition of the slaves.
  void set(const snapshot::FeedCondition& condition, Time now);
  /// Publishes slaves that have not been published for a period.
  void repeat(Time now);

 private:
  struct Published {
    snapshot::FeedSlave slave;
    Time at;
  };

  void publish(std::size_t position, const snapshot::FeedSlave& slave, Time now);

  std::chrono::nanoseconds period_;
  DdsEntities& entities_;
  std::vector<Published> published_;  ///< by position
  std::vector<snapshot::FeedSlave> newest_;
  std::optional<telemetry::Topology> topology_;  ///< last published topology
};

/// Whether a slave has changed, ignoring the time at which it was read.
[[nodiscard]] bool differ(snapshot::FeedSlave before, snapshot::FeedSlave now) noexcept;

}  // namespace driveline::bridge
