#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/discovery/topology.hpp"

namespace driveline::ecat_master {

/// The line at start and now, used to identify slaves that return without a station address.
struct LinePlaces {
  /// Topology at start, by slave. Empty: unknown.
  const Topology& start;
  /// By slave: identified by alias or device ID, without a fixed position.
  const std::vector<bool>& roaming;
  /// Current topology, by position. Empty: unknown.
  const Topology& now;
  /// By position: number of the slave by its station address, alias or device ID; empty for a new slave.
  std::span<const std::optional<std::size_t>> known;
};

/// The missing slaves that a new slave may be.
struct PlaceClaim {
  std::uint16_t position = 0;       ///< current position of the new slave
  std::vector<std::size_t> slaves;  ///< missing slaves, in line order
  bool certain = false;             ///< `slaves` has one element, and no other new slave claims it
};

/// Identifies new slaves by the wiring: a new slave is the missing slave that was connected to the same port of the
/// same slave at start. A slave behind another new slave follows once that one is identified. Where the wiring is
/// ambiguous (unknown, or roaming slaves in between), the order decides if there are as many new slaves as missing
/// slaves between two neighbours; otherwise each of these new slaves claims all of the missing slaves. New slaves where
/// no slave is missing have no claim. Not real-time safe.
[[nodiscard]] std::vector<PlaceClaim> place_newcomers(const LinePlaces& line);

}  // namespace driveline::ecat_master
