#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/discovery/topology.hpp"

namespace driveline::ecat_master {

/// The line at start and now, by which slaves that come back without a station address are told from each other.
struct LinePlaces {
  /// As found at start, by slave. Empty: not known.
  const Topology& start;
  /// By slave: known by its alias or device ID wherever it is plugged in; it has no place.
  const std::vector<bool>& roaming;
  /// As it is now, by position. Empty: not known.
  const Topology& now;
  /// By position: which slave it is by its station address, alias or device ID; nothing for a newcomer.
  std::span<const std::optional<std::size_t>> known;
};

/// Whom a newcomer may be.
struct PlaceClaim {
  std::uint16_t position = 0;       ///< of the newcomer, as the line is now
  std::vector<std::size_t> slaves;  ///< missing ones, in the order of the line
  bool certain = false;             ///< `slaves` has one, and no other newcomer can be it
};

/// Tells by the wiring who a newcomer is: the missing slave that hung on the same port of the same slave at start. One
/// behind a newcomer is found when that one is. Where wiring does not tell (it is not known, or roaming slaves stood in
/// between), the order between neighbours does when as many newcomers stand there as slaves are missing; otherwise all
/// of these claim all of those. Newcomers where nobody is missing have no claim. Not real-time safe.
[[nodiscard]] std::vector<PlaceClaim> place_newcomers(const LinePlaces& line);

}  // namespace driveline::ecat_master
