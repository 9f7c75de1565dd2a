// Restores station addresses that were lost or overwritten.
#include <algorithm>
#include <array>

#include "bus/write_protection.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "driveline/ecat_master/master.hpp"
#include "master/placement.hpp"

namespace driveline::ecat_master {
namespace {

/// A slave of the line by position: its station address and the alias that it loaded at power-on.
struct Seen {
  std::uint16_t station = 0;
  std::uint16_t alias = 0;
  bool answers = false;
  std::optional<std::uint16_t> device_id{};  ///< read when a slave with a planned device ID is missing
};

Result<std::vector<Seen>> read_station_addresses(Bus& bus) {
  std::array<std::byte, 1> type{};
  const auto count = bus.broadcast_read(wire::reg::kType.address, type);
  if (!count) return tl::unexpected(count.error());
  // Station address 0x0010 and alias 0x0012 in one read.
  std::vector<std::array<std::byte, 4>> data(*count);
  std::vector<Request> requests;
  for (std::uint16_t i = 0; i < *count; ++i) {
    requests.push_back(
        {wire::Command::kAprd, wire::DatagramAddress::position(i, wire::reg::kStationAddress.address), data[i]});
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < data.size(); ++i) {
    seen.push_back({bytes::load_le<std::uint16_t>(data[i]),
                    bytes::load_le<std::uint16_t>(std::span(data[i]).subspan(2)), requests[i].working_counter == 1});
  }
  return seen;
}

/// Identifies each of `seen` by its station address. A damaged frame may have overwritten addresses: when all slaves
/// are present and none of them may move, only the position decides; an address that several slaves have is ignored.
std::vector<std::optional<std::size_t>> by_address(std::span<const Seen> seen, std::span<const SlaveRef> refs,
                                                   bool fixed) {
  const bool whole = fixed && seen.size() == refs.size() &&
                     std::all_of(seen.begin(), seen.end(), [](const Seen& s) { return s.answers; });
  std::vector<std::optional<std::size_t>> known(seen.size());
  for (std::size_t position = 0; position < seen.size(); ++position) {
    const auto& one = seen[position];
    const auto has_it = [&one](SlaveRef ref) { return ref.station == one.station; };
    const auto found = std::find_if(refs.begin(), refs.end(), has_it);
    if (!one.answers || found == refs.end()) continue;
    const auto index = static_cast<std::size_t>(found - refs.begin());
    const auto same = std::count_if(
        seen.begin(), seen.end(), [&one](const Seen& other) { return other.answers && other.station == one.station; });
    if (whole ? index == position : same == 1) known[position] = index;
  }
  return known;
}

}  // namespace

/// A slave that was switched off has lost its station address. Known slaves are recognised by their address; a slave
/// with another address or none is the missing slave of that place, or the hot-connect slave with that alias.
Result<std::vector<Master::Readdressed>> Master::readdress_newcomers() {
  auto seen = read_station_addresses(bus_);
  if (!seen) return tl::unexpected(seen.error());
  const auto hot = [this](std::size_t slave) { return slaves_[slave].plan.hot_connect; };
  bool fixed = true;
  for (std::size_t i = 0; i < slaves_.size(); ++i) fixed = fixed && !hot(i);
  auto known = by_address(*seen, refs_, fixed);
  std::vector<bool> present(refs_.size());
  for (const auto& slave : known) {
    if (slave) present[*slave] = true;
  }
  bool by_id = false;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    by_id = by_id || (!present[i] && hot(i) && slaves_[i].plan.device_id);
  }
  if (by_id) {
    std::vector<std::uint16_t> strangers;
    for (std::size_t position = 0; position < seen->size(); ++position) {
      if ((*seen)[position].answers && !known[position]) strangers.push_back(static_cast<std::uint16_t>(position));
    }
    const auto ids = identify_newcomers(strangers);
    if (!ids) return tl::unexpected(ids.error());
    for (std::size_t i = 0; i < strangers.size(); ++i) (*seen)[strangers[i]].device_id = (*ids)[i];
  }
  std::vector<Readdressed> moved;
  const auto give_address = [&](std::size_t position, std::size_t slave) -> Result<void> {
    // The same fault may also have write-protected the slave.
    if (moved.empty()) {
      if (auto done = lift_write_protection(bus_, std::nullopt); !done) return done;
    }
    known[position] = slave;
    present[slave] = true;
    unproven_[slave] = true;
    moved.push_back({static_cast<std::uint16_t>(slave), (*seen)[position].station});
    const auto address = bytes::to_le_bytes(refs_[slave].station);
    return bus_.write_at_position(static_cast<std::uint16_t>(position), wire::reg::kStationAddress.address, address);
  };
  std::size_t reached = 0;
  for (std::size_t position = 0; position < seen->size(); ++position) {
    const auto& one = (*seen)[position];
    if (!one.answers) continue;
    reached = position + 1;
    if (known[position]) continue;
    for (std::size_t i = 0; i < slaves_.size(); ++i) {
      if (present[i] || !hot(i) || slaves_[i].plan.behind) continue;
      const auto alias = slaves_[i].plan.alias.value_or(slaves_[i].info.alias);
      const bool match =
          (one.alias != 0 && alias == one.alias) || (one.device_id && slaves_[i].plan.device_id == one.device_id);
      if (!match) continue;
      if (auto done = give_address(position, i); !done) return tl::unexpected(done.error());
      break;
    }
  }
  // Members of a hot-connect group follow their head.
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    const auto& behind = slaves_[i].plan.behind;
    if (present[i] || !behind) continue;
    const auto head = std::find(known.begin(), known.end(), position_of(behind->head));
    if (head == known.end() || !*head) continue;
    const auto position = static_cast<std::size_t>(head - known.begin()) + behind->distance;
    if (position >= reached || !(*seen)[position].answers || known[position]) continue;
    if (auto done = give_address(position, i); !done) return tl::unexpected(done.error());
  }
  // Slaves behind the break of a ring cannot be reached by position.
  const auto placed = place_by_wiring(std::span(known).first(reached));
  if (!placed) return tl::unexpected(placed.error());
  for (const auto& [position, slave] : *placed) {
    if (auto done = give_address(position, slave); !done) return tl::unexpected(done.error());
  }
  return moved;
}

/// Device IDs of slaves without a station address of this master.
Result<std::vector<std::optional<std::uint16_t>>> Master::identify_newcomers(std::span<const std::uint16_t> positions) {
  const auto guests = assign_temporary_addresses(positions);
  if (!guests) return tl::unexpected(guests.error());
  return read_device_ids(bus_, *guests);
}

}  // namespace driveline::ecat_master
