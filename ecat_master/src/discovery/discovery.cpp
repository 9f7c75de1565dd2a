#include "driveline/ecat_master/discovery/discovery.hpp"

#include <algorithm>
#include <array>

#include "bus/write_protection.hpp"
#include "discovery/sync_manager_uses.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "sii/sii_reader.hpp"

namespace driveline::ecat_master {
namespace {

Result<std::uint16_t> count_slaves(Bus& bus) {
  std::array<std::byte, 1> type{};
  auto count = bus.broadcast_read(wire::reg::kType.address, type);
  if (!count) return count;
  if (*count == 0) return tl::unexpected(Error{facts::NoSlaves{}});
  if (*count > kMaxSlaves) return tl::unexpected(Error{facts::TooManySlaves{.found = *count, .limit = kMaxSlaves}});
  return count;
}

/// An earlier master may have closed ports permanently (DL control, ETG.1000.4 Table 37), which hides the slaves behind
/// them. Resets all ports to automatic; slaves that then appear may have closed ports as well.
Result<std::uint16_t> open_ports(Bus& bus, std::uint16_t count) {
  constexpr auto kLoopControl = static_cast<std::uint16_t>(wire::reg::kDlControl.address + 1);
  const std::array<std::byte, 1> automatic{};
  for (;;) {
    if (auto done = bus.broadcast_write(kLoopControl, automatic); !done) return tl::unexpected(done.error());
    const auto now = count_slaves(bus);
    if (!now || *now <= count) return now;
    count = *now;
  }
}

/// Resets the settings of an earlier master: INIT with the error acknowledged, then all channels off.
Result<void> reset_slaves(Bus& bus) {
  const auto control = bytes::to_le_bytes(wire::AlControl{wire::AlState::kInit, true, false}.raw());
  if (auto done = bus.broadcast_write(wire::reg::kAlControl.address, control); !done)
    return tl::unexpected(done.error());
  return clear_channels(bus);
}

Result<std::vector<SlaveRef>> assign_addresses(Bus& bus, std::uint16_t count) {
  std::vector<SlaveRef> slaves;
  std::vector<std::array<std::byte, 2>> addresses(count);
  std::vector<Request> requests;
  for (std::uint16_t i = 0; i < count; ++i) {
    slaves.push_back({i, static_cast<std::uint16_t>(kFirstStationAddress + i)});
    addresses[i] = bytes::to_le_bytes(slaves.back().station);
    requests.push_back(
        {wire::Command::kApwr, wire::DatagramAddress::position(i, wire::reg::kStationAddress.address), addresses[i]});
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  for (std::uint16_t i = 0; i < count; ++i) {
    if (requests[i].working_counter == 1) continue;
    return tl::unexpected(Error{
        facts::WorkingCounter{.address = wire::reg::kStationAddress.address, .received = requests[i].working_counter},
        i});
  }
  return slaves;
}

/// Checks the words that a slave checks in its EEPROM at power-on.
std::optional<Error> check_configuration_area(SlaveRef slave, std::span<const std::byte> image) {
  constexpr std::size_t kArea = esi::SiiConfigArea::kSize;
  if (image.size() <= kArea) return std::nullopt;  // too short for any check
  const auto area = image.first<kArea>();
  if (std::all_of(area.begin(), area.end(), [](std::byte byte) { return byte == std::byte{0xFF}; })) {
    return Error{facts::SiiBlank{}, slave.position};
  }
  const facts::SiiChecksum checksum{.right = esi::sii_checksum(area),
                                    .found = std::to_integer<std::uint8_t>(image[kArea])};
  if (checksum.right == checksum.found) return std::nullopt;
  return Error{checksum, slave.position};
}

}  // namespace

SlaveInfo make_slave_info(SlaveRef ref, Result<std::vector<std::byte>> image) {
  SlaveInfo info;
  info.ref = ref;
  if (!image) {
    info.problem = image.error();
    return info;
  }
  const auto decoded = esi::decode_sii(*image);
  if (decoded) {
    info.alias = decoded->config.station_alias;
    info.description = esi::description_from_sii(*decoded);
    info.remarks = correct_sync_manager_uses(ref.position, info.description);
  }
  info.problem = check_configuration_area(ref, *image);
  if (!decoded && !info.problem) {
    const auto word = static_cast<std::uint16_t>(decoded.error().word_offset);
    info.problem = Error{facts::SiiContent{word}, ref.position};
  }
  info.sii = std::move(*image);
  return info;
}

Result<void> clear_channels(Bus& bus) {
  const std::array<std::byte, 8 * wire::SyncManagerChannel::kSize> no_sync_managers{};
  const std::array<std::byte, 8 * wire::FmmuEntity::kSize> no_fmmus{};
  if (auto done = bus.broadcast_write(wire::reg::kFmmu.address, no_fmmus); !done) return tl::unexpected(done.error());
  if (auto done = bus.broadcast_write(wire::reg::kSyncManager.address, no_sync_managers); !done)
    return tl::unexpected(done.error());
  return {};
}

Result<void> clear_channels(Bus& bus, std::span<const SlaveRef> slaves) {
  std::array<std::byte, 8 * wire::SyncManagerChannel::kSize> no_sync_managers{};
  std::array<std::byte, 8 * wire::FmmuEntity::kSize> no_fmmus{};
  std::vector<Request> requests;
  for (const auto& slave : slaves) {
    auto write = [&](std::uint16_t address, std::span<std::byte> zeros) {
      requests.push_back(
          {wire::Command::kFpwr, wire::DatagramAddress::physical(slave.station, address), zeros, 0, false});
    };
    write(wire::reg::kFmmu.address, no_fmmus);
    write(wire::reg::kSyncManager.address, no_sync_managers);
  }
  return bus.exchange().exchange(requests);
}

Result<std::vector<SlaveInfo>> inspect(Bus& bus, std::span<const SlaveRef> slaves) {
  auto images = read_sii(bus, slaves);
  if (!images) return tl::unexpected(images.error());
  std::vector<SlaveInfo> found;
  for (std::size_t i = 0; i < slaves.size(); ++i) found.push_back(make_slave_info(slaves[i], std::move((*images)[i])));
  return found;
}

Result<std::vector<SlaveInfo>> discover(Bus& bus) {
  const auto visible = count_slaves(bus);
  if (!visible) return tl::unexpected(visible.error());
  // Another master, or a damaged frame, may have locked slaves against writes.
  if (auto done = lift_write_protection(bus, std::nullopt); !done) return tl::unexpected(done.error());
  const auto count = open_ports(bus, *visible);
  if (!count) return tl::unexpected(count.error());
  if (auto done = reset_slaves(bus); !done) return tl::unexpected(done.error());
  const auto slaves = assign_addresses(bus, *count);
  if (!slaves) return tl::unexpected(slaves.error());
  return inspect(bus, *slaves);
}

}  // namespace driveline::ecat_master
