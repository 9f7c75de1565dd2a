#pragma once

#include <set>
#include <span>
#include <vector>

#include "driveline/slaves/line/wiring.hpp"

namespace driveline::bus_test {

/// A line that the campaign runs on. Slaves are numbered in the order in which frames pass them.
struct CampaignLine {
  const char* name;
  slaves::Wiring wiring;
  bool ring = false;
  std::vector<std::size_t> hot_connect{};  ///< slaves that are known by their alias
};

[[nodiscard]] std::vector<CampaignLine> campaign_lines();

/// Present cuts.
struct Cuts {
  std::set<std::size_t> off;           ///< slaves without supply
  std::vector<slaves::PortId> broken;  ///< cables, by one of their ends
};

/// Slaves that the interfaces reach one after the other: the wiring walked along, cuts left out.
struct Reached {
  std::set<std::size_t> slaves;
  std::size_t primary = 0;    ///< how many of them from the primary interface
  std::size_t secondary = 0;  ///< from the secondary one; 0 as long as the ring is closed
  bool closed = false;        ///< the secondary interface is reached from the primary one
};
[[nodiscard]] Reached reached(const slaves::Wiring& wiring, const Cuts& cuts);

/// Both ends of every cable between two slaves, each cable once.
[[nodiscard]] std::vector<slaves::PortId> cables(const slaves::Wiring& wiring);

}  // namespace driveline::bus_test
