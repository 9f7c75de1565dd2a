#include "configuration/process_data_setup.hpp"

#include <algorithm>

#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;

/// FMMUs assumed for a slave that is not on the line yet: one for each direction, and one for the AL status.
constexpr std::size_t kFewestFmmus = 3;

Error no_sync_manager(const ConfiguredSlave& slave, std::size_t bits) {
  return {facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>((bits + 7) / 8)}, slave.info.ref.position};
}

/// PDOs (all inputs or all outputs) that the EEPROM assigns to a sync manager; exchanged by a slave without planned
/// PDOs.
std::vector<motion::PdoMapping> assigned_pdos(const std::vector<esi::Pdo>& pdos) {
  std::vector<motion::PdoMapping> assigned;
  for (const auto& pdo : pdos) {
    if (!pdo.sync_manager) continue;
    auto& mapping = assigned.emplace_back(motion::PdoMapping{pdo.index, {}, pdo.sync_manager});
    for (const auto& entry : pdo.entries) mapping.objects.push_back({entry.index, entry.subindex, entry.bit_length});
  }
  return assigned;
}

/// Adds the input or output channels to `demand`.
Result<void> add_channels(const ConfiguredSlave& slave, const std::vector<motion::PdoMapping>& pdos, Use use,
                          ProcessDataDemand& demand) {
  const auto& managers = slave.info.description.sync_managers;
  const auto first = find_sync_manager(slave.info, use);
  std::vector<std::size_t> bits(managers.size());
  for (const auto& pdo : pdos) {
    if (pdo.bits() == 0) continue;
    const auto number = pdo.sync_manager ? pdo.sync_manager : first;
    if (!number || *number >= managers.size()) return tl::unexpected(no_sync_manager(slave, pdo.bits()));
    bits[*number] += pdo.bits();
  }
  for (std::size_t i = 0; i < managers.size(); ++i) {
    if (bits[i] == 0) continue;
    demand.channels.push_back(
        {use == Use::kOutputs, static_cast<std::uint8_t>(i), managers[i].start_address, (bits[i] + 7) / 8});
  }
  return {};
}

std::size_t channel_bytes(const ProcessDataDemand& demand, std::uint8_t sync_manager) {
  const auto found = std::find_if(demand.channels.begin(), demand.channels.end(),
                                  [=](const auto& channel) { return channel.sync_manager == sync_manager; });
  return found == demand.channels.end() ? 0 : found->bytes;
}

}  // namespace

motion::PdoConfiguration exchanged_pdos(const ConfiguredSlave& slave) {
  const auto& planned = slave.plan.pdos;
  // The PDOs assigned by the slave have been read; there may be none.
  if (slave.plan.own_pdos) return planned;
  if (!planned.outputs.empty() || !planned.inputs.empty()) return planned;
  return {assigned_pdos(slave.info.description.rx_pdos), assigned_pdos(slave.info.description.tx_pdos)};
}

std::optional<std::uint8_t> find_sync_manager(const SlaveInfo& slave, Use use) {
  const auto& managers = slave.description.sync_managers;
  const auto found = std::find_if(managers.begin(), managers.end(), [use](const auto& m) { return m.use == use; });
  if (found == managers.end()) return std::nullopt;
  return static_cast<std::uint8_t>(found - managers.begin());
}

RegisterWrite sync_manager_write(SlaveRef slave, std::uint8_t number, const esi::SyncManager& layout,
                                 std::uint16_t length) {
  wire::SyncManagerChannel channel;
  channel.start_address = layout.start_address;
  channel.length = length;
  channel.control = layout.control;
  channel.activate = length > 0 ? wire::SyncManagerActivate::kEnable : std::uint8_t{0};
  RegisterWrite write{slave, wire::reg::kSyncManager.at(number), std::vector<std::byte>(channel.kSize)};
  channel.encode(std::span(write.data).first<wire::SyncManagerChannel::kSize>());
  return write;
}

Result<ProcessDataDemand> make_demand(const ConfiguredSlave& slave) {
  ProcessDataDemand demand;
  const auto pdos = exchanged_pdos(slave);
  if (auto done = add_channels(slave, pdos.outputs, Use::kOutputs, demand); !done) return tl::unexpected(done.error());
  if (auto done = add_channels(slave, pdos.inputs, Use::kInputs, demand); !done) return tl::unexpected(done.error());
  demand.group = slave.plan.group;
  demand.lrw = slave.plan.lrw.value_or(!slave.info.description.not_lrw);
  demand.fmmu_uses = slave.info.description.fmmus;
  demand.al_status = true;
  if (const auto mailbox = find_sync_manager(slave.info, Use::kMailboxIn); mailbox && slave.mailbox) {
    demand.mailbox_status = static_cast<std::uint16_t>(wire::reg::kSyncManager.at(*mailbox) + 5);
  }
  return demand;
}

Result<std::vector<ProcessDataDemand>> make_demands(Bus& bus, std::span<const ConfiguredSlave> slaves) {
  std::vector<ProcessDataDemand> demands;
  std::vector<std::array<std::byte, 1>> counts(slaves.size());
  std::vector<Request> requests;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    auto demand = make_demand(slaves[i]);
    if (!demand) return tl::unexpected(demand.error());
    demands.push_back(std::move(*demand));
    const auto station = slaves[i].info.ref.station;
    requests.push_back(
        {wire::Command::kFprd, wire::DatagramAddress::physical(station, wire::reg::kFmmuCount.address), counts[i]});
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (requests[i].working_counter == 1 || !slaves[i].present) {
      demands[i].fmmus = slaves[i].present ? std::to_integer<std::size_t>(counts[i][0]) : kFewestFmmus;
      continue;
    }
    return tl::unexpected(
        Error{facts::WorkingCounter{.address = wire::reg::kFmmuCount.address, .received = requests[i].working_counter},
              slaves[i].info.ref.position});
  }
  return demands;
}

Result<std::vector<RegisterWrite>> process_data_setup(const ConfiguredSlave& slave, const ProcessImage& image) {
  const auto demand = make_demand(slave);
  if (!demand) return tl::unexpected(demand.error());
  std::vector<RegisterWrite> writes;
  const auto& managers = slave.info.description.sync_managers;
  for (std::size_t i = 0; i < managers.size(); ++i) {
    if (managers[i].use != Use::kOutputs && managers[i].use != Use::kInputs) continue;
    const auto number = static_cast<std::uint8_t>(i);
    const auto bytes = static_cast<std::uint16_t>(channel_bytes(*demand, number));
    writes.push_back(sync_manager_write(slave.info.ref, number, managers[i], bytes));
  }
  const auto fmmus = image.fmmus(slave.info.ref.position);
  if (fmmus.empty()) return writes;
  RegisterWrite write{slave.info.ref, wire::reg::kFmmu.address,
                      std::vector<std::byte>(fmmus.size() * wire::FmmuEntity::kSize)};
  for (std::size_t i = 0; i < fmmus.size(); ++i) {
    const auto place = std::span(write.data).subspan(i * wire::FmmuEntity::kSize);
    fmmus[i].encode(place.first<wire::FmmuEntity::kSize>());
  }
  writes.push_back(std::move(write));
  return writes;
}

Result<void> write_process_data_setup(Bus& bus, std::span<const ConfiguredSlave> slaves, const ProcessImage& image) {
  std::vector<RegisterWrite> writes;
  for (const auto& slave : slaves) {
    if (!slave.present) continue;
    auto setup = process_data_setup(slave, image);
    if (!setup) return tl::unexpected(setup.error());
    for (auto& write : *setup) writes.push_back(std::move(write));
  }
  return bus.write_all(writes);
}

}  // namespace driveline::ecat_master
