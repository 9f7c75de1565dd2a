#include "sii/sii_ownership.hpp"

#include <array>

#include "driveline/wire/sii_access.hpp"

namespace driveline::ecat_master {
namespace {

namespace sii = wire::sii_access;

Request owner_access(wire::Command command, const SlaveRef& slave, std::span<std::byte> data) {
  return {command, wire::DatagramAddress::physical(slave.station, wire::reg::kSiiConfiguration.address), data};
}

}  // namespace

Result<std::vector<SlaveRef>> take_from_applications(Bus& bus, std::span<const SlaveRef> slaves) {
  std::vector<std::array<std::byte, 1>> owners(slaves.size());
  std::array force{std::byte{sii::kConfigForceEcat}};
  std::array release{std::byte{0}};
  // Each owner is read before it is changed. If the frame is repeated because its answer was lost, the owner is
  // unknown, and the interface stays with the master.
  std::vector<Request> requests;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    requests.push_back(owner_access(wire::Command::kFprd, slaves[i], owners[i]));
    requests.push_back(owner_access(wire::Command::kFpwr, slaves[i], force));
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<SlaveRef> owned;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    const bool application = (owners[i][0] & std::byte{sii::kConfigPdiOwns}) != std::byte{0};
    if (requests[2 * i].working_counter == 1 && application) owned.push_back(slaves[i]);
  }
  requests.clear();
  for (const auto& slave : slaves) requests.push_back(owner_access(wire::Command::kFpwr, slave, release));
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  return owned;
}

Result<void> give_to_applications(Bus& bus, std::span<const SlaveRef> slaves) {
  if (slaves.empty()) return {};
  std::vector<RegisterWrite> writes;
  for (const auto& slave : slaves) {
    writes.push_back({slave, wire::reg::kSiiConfiguration.address, {std::byte{sii::kConfigPdiOwns}}});
  }
  return bus.write_all(writes);
}

}  // namespace driveline::ecat_master
