#include "driveline/ecat_master/discovery/line_survey.hpp"

#include <algorithm>
#include <set>

#include "driveline/ecat_master/discovery/discovery.hpp"
#include "sii/sii_reader.hpp"

namespace driveline::ecat_master {
namespace {

constexpr std::size_t kAddressBytes = 4;  // 0x0010..0x0013: station address, alias

Error silent(std::uint16_t position, std::uint16_t address) {
  return {facts::WorkingCounter{.address = address}, position};
}

/// Accesses all slaves by position at once.
Result<void> for_all(Bus& bus, wire::Command command, std::uint16_t address,
                     std::span<std::array<std::byte, kAddressBytes>> data, std::size_t bytes) {
  std::vector<Request> requests;
  for (std::size_t i = 0; i < data.size(); ++i) {
    requests.push_back({command, wire::DatagramAddress::position(static_cast<std::uint16_t>(i), address),
                        std::span(data[i]).first(bytes)});
  }
  if (auto done = bus.exchange().exchange(requests); !done) return done;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (requests[i].working_counter != 1) {
      return tl::unexpected(silent(static_cast<std::uint16_t>(i), address));
    }
  }
  return {};
}

bool usable(std::span<const SurveyedSlave> slaves) {
  std::set<std::uint16_t> stations;
  return std::all_of(slaves.begin(), slaves.end(), [&stations](const SurveyedSlave& slave) {
    return slave.ref.station != 0 && stations.insert(slave.ref.station).second;
  });
}

Result<void> assign_stations(Bus& bus, std::span<SurveyedSlave> slaves) {
  std::vector<std::array<std::byte, kAddressBytes>> data(slaves.size());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    slaves[i].ref.station = static_cast<std::uint16_t>(kFirstStationAddress + i);
    bytes::store_le(std::span(data[i]).first<2>(), slaves[i].ref.station);
  }
  return for_all(bus, wire::Command::kApwr, wire::reg::kStationAddress.address, data, 2);
}

}  // namespace

Result<std::vector<SurveyedSlave>> survey(Bus& bus, SurveyAddresses policy) {
  const auto states = peek_states(bus);
  if (!states) return tl::unexpected(states.error());
  if (states->size() > kMaxSlaves) {
    return tl::unexpected(
        Error{facts::TooManySlaves{.found = static_cast<std::uint32_t>(states->size()), .limit = kMaxSlaves}});
  }
  std::vector<std::array<std::byte, kAddressBytes>> addresses(states->size());
  const auto read = for_all(bus, wire::Command::kAprd, wire::reg::kStationAddress.address, addresses, kAddressBytes);
  if (!read) return tl::unexpected(read.error());
  std::vector<SurveyedSlave> slaves;
  for (std::size_t i = 0; i < states->size(); ++i) {
    const auto station = bytes::load_le<std::uint16_t>(addresses[i]);
    const auto alias = bytes::load_le<std::uint16_t>(std::span(addresses[i]).subspan(2));
    slaves.push_back({{static_cast<std::uint16_t>(i), station}, alias, (*states)[i]});
  }
  if (policy == SurveyAddresses::kComplete && !usable(slaves)) {
    if (auto done = assign_stations(bus, slaves); !done) return tl::unexpected(done.error());
  }
  return slaves;
}

std::vector<Result<std::vector<std::byte>>> read_each_sii(Bus& bus, std::span<const SlaveRef> slaves) {
  std::vector<Result<std::vector<std::byte>>> results;
  if (auto all = read_sii(bus, slaves)) {
    for (auto& image : *all) results.emplace_back(std::move(image));
    return results;
  }
  for (const auto& slave : slaves) {
    auto image = read_sii(bus, {&slave, 1});
    if (image) {
      results.emplace_back(std::move(image->front()));
    } else {
      results.emplace_back(tl::unexpected(image.error()));
    }
  }
  return results;
}

Result<EscInformation> read_esc_information(Bus& bus, SlaveRef slave) {
  std::array<std::byte, 10> raw{};
  if (auto done = bus.read(slave, wire::reg::kType.address, raw); !done) return tl::unexpected(done.error());
  EscInformation info;
  const auto byte = [&raw](std::size_t at) { return std::to_integer<std::uint8_t>(raw[at]); };
  info.type = byte(wire::reg::kType.address);
  info.revision = byte(wire::reg::kRevision.address);
  info.build = bytes::load_le<std::uint16_t>(std::span(raw).subspan(wire::reg::kBuild.address));
  info.fmmus = byte(wire::reg::kFmmuCount.address);
  info.sync_managers = byte(wire::reg::kSyncManagerCount.address);
  info.ram_kib = byte(wire::reg::kRamSize.address);
  info.port_descriptor = byte(wire::reg::kPortDescriptor.address);
  info.features = bytes::load_le<std::uint16_t>(std::span(raw).subspan(wire::reg::kFeatures.address));
  const auto dl_status = bus.read(slave, wire::reg::kDlStatus);
  if (!dl_status) return tl::unexpected(dl_status.error());
  info.dl_status = wire::DlStatus::from_raw(*dl_status);
  std::array<std::byte, 16> times{};
  // Controllers without clocks may lack the registers; their times stay zero.
  if (auto touched = bus.try_read(slave, wire::reg::kReceiveTimePort.address, times); !touched) {
    return tl::unexpected(touched.error());
  }
  for (unsigned port = 0; port < 4; ++port) {
    info.receive_time_ns[port] = bytes::load_le<std::uint32_t>(std::span(times).subspan(4 * port));
  }
  return info;
}

std::string_view esc_type_name(std::uint8_t type) noexcept {
  // ESC data sheet section II, register 0x0000.
  switch (type) {
    case 0x02:
      return "ESC10/ESC20";
    case 0x04:
      return "IP core";
    case 0x11:
      return "ET1100";
    case 0x12:
      return "ET1200";
    default:
      return {};
  }
}

}  // namespace driveline::ecat_master
