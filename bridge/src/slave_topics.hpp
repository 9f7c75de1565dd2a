#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "dds_entities.hpp"
#include "driveline.h"
#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"

namespace driveline::bridge {

/// Publishes the slaves of a line, each when something of it has changed and now and then, and the topology when that
/// has changed.
class SlaveTopics {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `entities` must outlive it.
  SlaveTopics(const DdsConfig& config, DdsEntities& entities) : period_(config.slave_period), entities_(entities) {}

  /// What is known of the slaves now.
  void set(const snapshot::FeedCondition& condition, Time now);
  /// Publishes slaves that were not published for a period.
  void repeat(Time now);

 private:
  struct Told {
    snapshot::FeedSlave slave;
    Time at;
  };

  void publish(std::size_t position, const snapshot::FeedSlave& slave, Time now);

  std::chrono::nanoseconds period_;
  DdsEntities& entities_;
  std::vector<Told> told_;  ///< by position
  std::vector<snapshot::FeedSlave> newest_;
  std::optional<telemetry::Topology> topology_;  ///< as published
};

/// Whether a slave is another than before, but for the time at which it was read.
[[nodiscard]] bool differ(snapshot::FeedSlave before, snapshot::FeedSlave now) noexcept;

}  // namespace driveline::bridge
