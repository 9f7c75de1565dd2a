#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "driveline/canopen_master/can_master.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"

namespace driveline::runtime {

/// The nodes of a CAN line for the telemetry, in the records of slaves: the station is the node-ID, and the states have
/// the numbers of the EtherCAT states that mean the same (Operational: OP, Pre-operational: PREOP, Stopped: SAFEOP).
/// Belongs to the thread that owns the master.
class NodeFeed {
 public:
  /// Both must outlive it.
  NodeFeed(const canopen::CanMaster& master, const rt::Clock& clock) : master_(master), clock_(clock) {}

  /// Takes what the master knows of the nodes. False: nothing has changed, and the last time was less than a second
  /// ago; not with `now`.
  [[nodiscard]] bool poll(bool now);
  /// Sets the owners of the axes, by axis number; empty: none. True: they have changed.
  [[nodiscard]] bool set_owners(const std::vector<std::string>& owners);
  /// Returns the present data.
  [[nodiscard]] const snapshot::FeedCondition& condition() const noexcept { return condition_; }

 private:
  const canopen::CanMaster& master_;
  const rt::Clock& clock_;
  snapshot::FeedCondition condition_;
  std::vector<unsigned> seen_;  ///< phases and states of the nodes at the last time
  std::chrono::nanoseconds due_{0};
};

}  // namespace driveline::runtime
