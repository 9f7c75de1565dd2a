// Identifies slaves that are on the line without a station address among the missing ones.
#include <algorithm>

#include "driveline/ecat_master/master.hpp"
#include "master/placement.hpp"
#include "sii/sii_reader.hpp"

namespace driveline::ecat_master {

Result<std::vector<std::pair<std::size_t, std::size_t>>> Master::place_by_wiring(
    std::span<const std::optional<std::size_t>> known) {
  std::vector<std::pair<std::size_t, std::size_t>> placed;
  unplaced_.assign(slaves_.size(), std::nullopt);
  if (std::all_of(known.begin(), known.end(), [](const auto& slave) { return slave.has_value(); })) return placed;
  std::vector<bool> roaming;
  for (const auto& slave : slaves_) roaming.push_back(slave.plan.hot_connect);
  auto facts = read_port_facts(bus_, static_cast<std::uint16_t>(known.size()));
  if (!facts) return tl::unexpected(facts.error());
  const auto now = build_topology(*facts).value_or(Topology{});
  const auto claims = place_newcomers({topology_, roaming, now, known});
  if (auto done = settle_claims(claims, placed); !done) return tl::unexpected(done.error());
  return placed;
}

/// Where a new slave may be several missing slaves, the serial number decides; without it the new slave gets no
/// address.
Result<void> Master::settle_claims(std::span<const PlaceClaim> claims,
                                   std::vector<std::pair<std::size_t, std::size_t>>& placed) {
  std::vector<PlaceClaim> doubtful;
  std::vector<std::uint16_t> positions;
  for (const auto& claim : claims) {
    if (claim.certain) {
      placed.emplace_back(claim.position, claim.slaves.front());
    } else {
      doubtful.push_back(claim);
      positions.push_back(claim.position);
    }
  }
  if (doubtful.empty()) return {};
  const auto serials = serials_of_newcomers(positions);
  if (!serials) return tl::unexpected(serials.error());
  for (std::size_t n = 0; n < doubtful.size(); ++n) {
    const auto serial = (*serials)[n];
    const auto& slaves = doubtful[n].slaves;
    const auto is_it = [&](std::size_t slave) { return slaves_[slave].info.description.serial_number == serial; };
    const bool unique = serial != 0 && std::count(serials->begin(), serials->end(), serial) == 1 &&
                        std::count_if(slaves.begin(), slaves.end(), is_it) == 1;
    if (unique) placed.emplace_back(doubtful[n].position, *std::find_if(slaves.begin(), slaves.end(), is_it));
  }
  const auto is_placed = [&placed](auto member, std::size_t value) {
    return std::any_of(placed.begin(), placed.end(), [=](const auto& one) { return one.*member == value; });
  };
  using Placed = std::pair<std::size_t, std::size_t>;
  for (const auto& claim : doubtful) {
    if (is_placed(&Placed::first, claim.position)) continue;
    for (const auto slave : claim.slaves) {
      if (is_placed(&Placed::second, slave)) continue;
      const auto returned = std::count_if(doubtful.begin(), doubtful.end(),
                                          [&claim](const PlaceClaim& other) { return other.slaves == claim.slaves; });
      unplaced_[slave] = Error{facts::PlaceUnknown{.missing = static_cast<std::uint32_t>(claim.slaves.size()),
                                                   .returned = static_cast<std::uint32_t>(returned)},
                               static_cast<std::uint16_t>(slave)};
    }
  }
  return {};
}

/// Gives slaves without a station address of this master a temporary one until they are identified.
Result<std::vector<SlaveRef>> Master::assign_temporary_addresses(std::span<const std::uint16_t> positions) {
  // Above those of any line (kMaxSlaves).
  constexpr std::uint16_t kTemporary = 0x3000;
  std::vector<SlaveRef> guests;
  for (const auto position : positions) {
    const SlaveRef guest{position, static_cast<std::uint16_t>(kTemporary + position)};
    const auto address = bytes::to_le_bytes(guest.station);
    if (auto done = bus_.write_at_position(position, wire::reg::kStationAddress.address, address); !done)
      return tl::unexpected(done.error());
    guests.push_back(guest);
  }
  return guests;
}

/// Serial numbers from the EEPROMs of slaves without a station address of this master; 0: none, or unreadable.
Result<std::vector<std::uint32_t>> Master::serials_of_newcomers(std::span<const std::uint16_t> positions) {
  const auto guests = assign_temporary_addresses(positions);
  if (!guests) return tl::unexpected(guests.error());
  const auto infos = inspect(bus_, *guests);
  if (!infos) return tl::unexpected(infos.error());
  std::vector<std::uint32_t> serials;
  for (const auto& info : *infos) serials.push_back(info.usable() ? info.description.serial_number : 0);
  return serials;
}

/// Another device is at the position of this slave and loses its address, so that the right one can join.
Result<void> Master::refuse(std::size_t slave, const Error& error) {
  if (error.is<facts::IdentityMismatch>()) {
    // If the write fails, the device is gone again, together with its address.
    static_cast<void>(bus_.write(refs_[slave], wire::reg::kStationAddress, 0).has_value());
  }
  return tl::unexpected(error);
}

}  // namespace driveline::ecat_master
