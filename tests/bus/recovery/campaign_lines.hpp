#pragma once

#include <set>
#include <span>
#include <vector>

#include "driveline/slaves/line/wiring.hpp"

namespace driveline::bus_test {

/// A line for the campaign. Slaves are numbered in the order in which frames pass them.
struct CampaignLine {
  const char* name;
  slaves::Wiring wiring;
  bool ring = false;
  std::vector<std::size_t> hot_connect{};  ///< slaves that are identified by their alias
};

[[nodiscard]] std::vector<CampaignLine> campaign_lines();

/// The present interruptions of a line.
struct Cuts {
  std::set<std::size_t> off;           ///< slaves without supply
  std::vector<slaves::PortId> broken;  ///< broken cables, by one of their ends
};

/// The slaves that the interfaces reach, in order, found by following the wiring without the cuts.
struct Reached {
  std::set<std::size_t> slaves;
  std::size_t primary = 0;    ///< number of slaves reached from the primary interface
  std::size_t secondary = 0;  ///< number of slaves reached from the secondary one; 0 while the ring is closed
  bool closed = false;        ///< the primary interface reaches the secondary one
};
[[nodiscard]] Reached reached(const slaves::Wiring& wiring, const Cuts& cuts);

/// Both ends of every cable between two slaves, each cable once.
[[nodiscard]] std::vector<slaves::PortId> cables(const slaves::Wiring& wiring);

}  // namespace driveline::bus_test
