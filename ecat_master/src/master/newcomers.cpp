// Identifies slaves that are on the line without a station address among the missing ones.
#include "master/newcomers.hpp"

#include <algorithm>

#include "sii/sii_reader.hpp"

namespace driveline::ecat_master {

Result<std::vector<Newcomers::Place>> Newcomers::find_by_wiring(const Survey& line) {
  std::vector<Place> placed;
  unplaced_.assign(line_.slaves.size(), std::nullopt);
  // Slaves behind the break of a ring cannot be reached by position.
  const auto known = std::span(line.known).first(line.reached);
  if (std::all_of(known.begin(), known.end(), [](const auto& slave) { return slave.has_value(); })) return placed;
  std::vector<bool> roaming;
  for (const auto& slave : line_.slaves) roaming.push_back(slave.plan.hot_connect);
  auto facts = read_port_facts(line_.bus, static_cast<std::uint16_t>(known.size()));
  if (!facts) return tl::unexpected(facts.error());
  const auto now = build_topology(*facts).value_or(Topology{});
  const auto claims = place_newcomers({line_.topology, roaming, now, known});
  if (auto done = settle_claims(claims, placed); !done) return tl::unexpected(done.error());
  return placed;
}

/// Where a new slave may be several missing slaves, the serial number decides; without it the new slave gets no
/// address.
Result<void> Newcomers::settle_claims(std::span<const PlaceClaim> claims, std::vector<Place>& placed) {
  std::vector<PlaceClaim> doubtful;
  for (const auto& claim : claims) {
    if (claim.certain) {
      placed.emplace_back(claim.position, claim.slaves.front());
    } else {
      doubtful.push_back(claim);
    }
  }
  if (doubtful.empty()) return {};
  if (auto done = place_by_serial(doubtful, placed); !done) return done;
  explain_unplaced(doubtful, placed);
  return {};
}

Result<void> Newcomers::place_by_serial(std::span<const PlaceClaim> doubtful, std::vector<Place>& placed) {
  std::vector<std::uint16_t> positions;
  for (const auto& claim : doubtful) positions.push_back(claim.position);
  const auto guests = assign_temporary_addresses(positions);
  if (!guests) return tl::unexpected(guests.error());
  const auto infos = inspect(line_.bus, *guests);
  if (!infos) return tl::unexpected(infos.error());
  std::vector<std::uint32_t> serials;  // 0: none, or unreadable
  for (const auto& info : *infos) serials.push_back(info.usable() ? info.description.serial_number : 0);
  for (std::size_t n = 0; n < doubtful.size(); ++n) {
    const auto serial = serials[n];
    const auto& slaves = doubtful[n].slaves;
    const auto is_it = [&](std::size_t slave) { return line_.slaves[slave].info.description.serial_number == serial; };
    const bool unique = serial != 0 && std::count(serials.begin(), serials.end(), serial) == 1 &&
                        std::count_if(slaves.begin(), slaves.end(), is_it) == 1;
    if (unique) placed.emplace_back(doubtful[n].position, *std::find_if(slaves.begin(), slaves.end(), is_it));
  }
  return {};
}

void Newcomers::explain_unplaced(std::span<const PlaceClaim> doubtful, std::span<const Place> placed) {
  const auto is_placed = [placed](auto member, std::size_t value) {
    return std::any_of(placed.begin(), placed.end(), [=](const auto& one) { return one.*member == value; });
  };
  for (const auto& claim : doubtful) {
    if (is_placed(&Place::first, claim.position)) continue;
    for (const auto slave : claim.slaves) {
      if (is_placed(&Place::second, slave)) continue;
      const auto returned = std::count_if(doubtful.begin(), doubtful.end(),
                                          [&claim](const PlaceClaim& other) { return other.slaves == claim.slaves; });
      unplaced_[slave] = Error{facts::PlaceUnknown{.missing = static_cast<std::uint32_t>(claim.slaves.size()),
                                                   .returned = static_cast<std::uint32_t>(returned)},
                               static_cast<std::uint16_t>(slave)};
    }
  }
}

/// Gives slaves without a station address of this master a temporary one until they are identified.
Result<std::vector<SlaveRef>> Newcomers::assign_temporary_addresses(std::span<const std::uint16_t> positions) {
  // Above those of any line (kMaxSlaves).
  constexpr std::uint16_t kTemporary = 0x3000;
  std::vector<SlaveRef> guests;
  for (const auto position : positions) {
    const SlaveRef guest{position, static_cast<std::uint16_t>(kTemporary + position)};
    const auto address = bytes::to_le_bytes(guest.station);
    if (auto done = line_.bus.write_at_position(position, wire::reg::kStationAddress.address, address); !done)
      return tl::unexpected(done.error());
    guests.push_back(guest);
  }
  return guests;
}

}  // namespace driveline::ecat_master
