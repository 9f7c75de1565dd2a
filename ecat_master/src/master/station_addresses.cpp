// Restores station addresses that were lost or overwritten.
#include <algorithm>
#include <array>

#include "bus/write_protection.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "master/newcomers.hpp"

namespace driveline::ecat_master {

namespace {

Result<std::vector<SeenSlave>> read_station_addresses(Bus& bus) {
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
  std::vector<SeenSlave> seen;
  for (std::size_t i = 0; i < data.size(); ++i) {
    seen.push_back({bytes::load_le<std::uint16_t>(data[i]),
                    bytes::load_le<std::uint16_t>(std::span(data[i]).subspan(2)), requests[i].working_counter == 1});
  }
  return seen;
}

/// Identifies each of `seen` by its station address. A damaged frame may have overwritten addresses: when all slaves
/// are present and none of them may move, only the position decides; an address that several slaves have is ignored.
std::vector<std::optional<std::size_t>> by_address(std::span<const SeenSlave> seen, std::span<const SlaveRef> refs,
                                                   bool fixed) {
  const bool whole = fixed && seen.size() == refs.size() &&
                     std::all_of(seen.begin(), seen.end(), [](const SeenSlave& s) { return s.answers; });
  std::vector<std::optional<std::size_t>> known(seen.size());
  for (std::size_t position = 0; position < seen.size(); ++position) {
    const auto& one = seen[position];
    const auto has_it = [&one](SlaveRef ref) { return ref.station == one.station; };
    const auto found = std::find_if(refs.begin(), refs.end(), has_it);
    if (!one.answers || found == refs.end()) continue;
    const auto index = static_cast<std::size_t>(found - refs.begin());
    const auto same = std::count_if(seen.begin(), seen.end(), [&one](const SeenSlave& other) {
      return other.answers && other.station == one.station;
    });
    if (whole ? index == position : same == 1) known[position] = index;
  }
  return known;
}

}  // namespace

bool Newcomers::is_missing_roamer(const Survey& line, std::size_t slave) const {
  return !line.present[slave] && line_.slaves[slave].plan.hot_connect;
}

/// A slave that was switched off has lost its station address. Known slaves are recognised by their address; a slave
/// with another address or none is the missing slave of that place, or the hot-connect slave with that alias.
Result<std::vector<Newcomers::Readdressed>> Newcomers::readdress() {
  auto line = survey();
  if (!line) return tl::unexpected(line.error());
  if (auto done = read_ids(*line); !done) return tl::unexpected(done.error());
  if (auto done = give_addresses(find_roaming(*line), *line); !done) return tl::unexpected(done.error());
  if (auto done = give_addresses(find_behind_heads(*line), *line); !done) return tl::unexpected(done.error());
  const auto placed = find_by_wiring(*line);
  if (!placed) return tl::unexpected(placed.error());
  if (auto done = give_addresses(*placed, *line); !done) return tl::unexpected(done.error());
  return std::move(line->moved);
}

Result<Newcomers::Survey> Newcomers::survey() {
  auto seen = read_station_addresses(line_.bus);
  if (!seen) return tl::unexpected(seen.error());
  const bool fixed = std::none_of(line_.slaves.begin(), line_.slaves.end(),
                                  [](const ConfiguredSlave& slave) { return slave.plan.hot_connect; });
  Survey line{std::move(*seen), {}, std::vector<bool>(line_.refs.size()), 0, {}};
  line.known = by_address(line.seen, line_.refs, fixed);
  for (std::size_t position = 0; position < line.seen.size(); ++position) {
    if (line.known[position]) line.present[*line.known[position]] = true;
    if (line.seen[position].answers) line.reached = position + 1;
  }
  return line;
}

/// Reads the device IDs of strangers if a missing slave is recognised by its device ID.
Result<void> Newcomers::read_ids(Survey& line) {
  bool wanted = false;
  for (std::size_t i = 0; i < line_.slaves.size(); ++i) {
    wanted = wanted || (is_missing_roamer(line, i) && line_.slaves[i].plan.device_id);
  }
  if (!wanted) return {};
  std::vector<std::uint16_t> strangers;
  for (std::size_t position = 0; position < line.seen.size(); ++position) {
    if (line.seen[position].answers && !line.known[position]) strangers.push_back(static_cast<std::uint16_t>(position));
  }
  const auto guests = assign_temporary_addresses(strangers);
  if (!guests) return tl::unexpected(guests.error());
  const auto ids = read_device_ids(line_.bus, *guests);
  if (!ids) return tl::unexpected(ids.error());
  for (std::size_t i = 0; i < strangers.size(); ++i) line.seen[strangers[i]].device_id = (*ids)[i];
  return {};
}

/// Hot-connect slaves, by their alias or device ID.
std::vector<Newcomers::Place> Newcomers::find_roaming(const Survey& line) const {
  std::vector<Place> found;
  std::vector<bool> taken = line.present;
  for (std::size_t position = 0; position < line.reached; ++position) {
    const auto& one = line.seen[position];
    if (!one.answers || line.known[position]) continue;
    for (std::size_t i = 0; i < line_.slaves.size(); ++i) {
      const auto& slave = line_.slaves[i];
      if (taken[i] || !slave.plan.hot_connect || slave.plan.behind) continue;
      const auto alias = slave.plan.alias.value_or(slave.info.alias);
      const bool match =
          (one.alias != 0 && alias == one.alias) || (one.device_id && slave.plan.device_id == one.device_id);
      if (!match) continue;
      taken[i] = true;
      found.emplace_back(position, i);
      break;
    }
  }
  return found;
}

/// Members of a hot-connect group, which follow their head.
std::vector<Newcomers::Place> Newcomers::find_behind_heads(const Survey& line) const {
  const auto& plans = line_.comparison.plan_of_slave;
  std::vector<Place> found;
  auto known = line.known;
  for (std::size_t i = 0; i < line_.slaves.size(); ++i) {
    const auto& behind = line_.slaves[i].plan.behind;
    if (line.present[i] || !behind) continue;
    const auto plan = std::find(plans.begin(), plans.end(), std::optional(behind->head));
    if (plan == plans.end()) continue;
    const auto head =
        std::find(known.begin(), known.end(), std::optional(static_cast<std::size_t>(plan - plans.begin())));
    if (head == known.end()) continue;
    const auto position = static_cast<std::size_t>(head - known.begin()) + behind->distance;
    if (position >= line.reached || !line.seen[position].answers || known[position]) continue;
    known[position] = i;
    found.emplace_back(position, i);
  }
  return found;
}

Result<void> Newcomers::give_addresses(std::span<const Place> places, Survey& line) {
  for (const auto& [position, slave] : places) {
    // The same fault may also have write-protected the slave.
    if (line.moved.empty()) {
      if (auto done = lift_write_protection(line_.bus, std::nullopt); !done) return done;
    }
    line.known[position] = slave;
    line.present[slave] = true;
    unproven_[slave] = true;
    line.moved.push_back({static_cast<std::uint16_t>(slave), line.seen[position].station});
    const auto address = bytes::to_le_bytes(line_.refs[slave].station);
    const auto done =
        line_.bus.write_at_position(static_cast<std::uint16_t>(position), wire::reg::kStationAddress.address, address);
    if (!done) return done;
  }
  return {};
}

}  // namespace driveline::ecat_master
