#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/discovery/topology.hpp"

namespace driveline::ecat_master {

/// The line at start and now, by which slaves that come back without a station address are identified.
struct LinePlaces {
  /// As found at start, by slave. Empty: not known.
  const Topology& start;
  /// By slave: identified by alias or device ID, without a fixed place.
  const std::vector<bool>& roaming;
  /// As it is now, by position. Empty: not known.
  const Topology& now;
  /// By position: number of the slave by its station address, alias or device ID; nothing for a newcomer.
  std::span<const std::optional<std::size_t>> known;
};

/// The missing slaves that a newcomer may be.
struct PlaceClaim {
  std::uint16_t position = 0;       ///< of the newcomer, as the line is now
  std::vector<std::size_t> slaves;  ///< missing ones, in the order of the line
  bool certain = false;             ///< `slaves` has one element, and no other newcomer claims it
};

/// Identifies newcomers by the wiring: a newcomer is the missing slave that was connected to the same port of the same
/// slave at start. One behind another newcomer follows once that is identified. Where the wiring is ambiguous (not
/// known, or roaming slaves in between), the order decides if there are as many newcomers as missing slaves between two
/// neighbours; otherwise each of these newcomers claims all of the missing slaves. Newcomers where no slave is missing
/// have no claim. Not real-time safe.
[[nodiscard]] std::vector<PlaceClaim> place_newcomers(const LinePlaces& line);

}  // namespace driveline::ecat_master
