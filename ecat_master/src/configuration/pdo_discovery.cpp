#include "driveline/ecat_master/configuration/pdo_discovery.hpp"

#include <algorithm>
#include <optional>

#include "configuration/assigned_pdos.hpp"
#include "configuration/list_read.hpp"
#include "driveline/ecat_master/configuration/idn_mapping.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;

bool carries_process_data(Use use) {
  return use == Use::kOutputs || use == Use::kInputs;
}

/// The PDOs that the description assigns to a sync manager; `assigned` accepts its number.
template <typename Assigned>
std::vector<motion::PdoMapping> described_pdos(const std::vector<esi::Pdo>& pdos, Assigned assigned) {
  std::vector<motion::PdoMapping> mappings;
  for (const auto& pdo : pdos) {
    if (!pdo.sync_manager || !assigned(*pdo.sync_manager)) continue;
    auto& mapping = mappings.emplace_back(motion::PdoMapping{pdo.index, {}, pdo.sync_manager});
    for (const auto& entry : pdo.entries) mapping.objects.push_back({entry.index, entry.subindex, entry.bit_length});
  }
  return mappings;
}

/// The configurations of slaves, put together from what is read for each of their sync managers.
class Discovery {
 public:
  Discovery(std::span<const SlaveInfo> slaves, StartupNotes& notes)
      : slaves_(slaves), notes_(notes), results_(slaves.size()) {}

  std::vector<Result<motion::PdoConfiguration>> run(MailboxEngine& engine) {
    std::vector<SyncManagerPlace> places;
    for (std::size_t i = 0; i < slaves_.size(); ++i) {
      const auto& device = slaves_[i].description;
      if (!device.mailbox.coe) {
        results_[i] = maps_by_idn(device) ? read_idn_mapping(engine, slaves_[i]) : pdo_configuration_from_sii(device);
        continue;
      }
      for (std::size_t n = 0; n < device.sync_managers.size(); ++n) {
        if (carries_process_data(device.sync_managers[n].use)) places.push_back({i, static_cast<std::uint8_t>(n)});
      }
    }
    auto read = read_assignments(engine, slaves_, places, notes_);
    for (std::size_t i = 0; i < places.size(); ++i) take(places[i], std::move(read[i]));
    return std::move(results_);
  }

 private:
  void take(const SyncManagerPlace& place, Result<std::vector<motion::PdoMapping>> pdos) {
    auto& result = results_[place.slave];
    if (!pdos && hides_assignment(place, pdos.error())) pdos = described(place, pdos.error());
    if (!pdos) {
      if (result) result = tl::unexpected(pdos.error());
      return;
    }
    if (!result) return;
    auto& direction = use_of(place) == Use::kOutputs ? result->outputs : result->inputs;
    for (auto& pdo : *pdos) direction.push_back(std::move(pdo));
  }

  /// Whether the slave aborts the transfer of the assignment, with whatever code. An assigned PDO without a mapping
  /// that is known is an error.
  static bool hides_assignment(const SyncManagerPlace& place, const Error& error) {
    const auto* abort = error.as<facts::SdoAbort>();
    return abort != nullptr && abort->object.index == kPdoAssignment + place.sync_manager;
  }

  /// The PDOs of the description for a sync manager whose PDOs the slave does not show.
  std::vector<motion::PdoMapping> described(const SyncManagerPlace& place, const Error& error) {
    const auto& device = slaves_[place.slave].description;
    const auto number = place.sync_manager;
    const auto& known = use_of(place) == Use::kOutputs ? device.rx_pdos : device.tx_pdos;
    auto pdos = described_pdos(known, [number](std::uint8_t other) { return other == number; });
    const auto& abort = *error.as<facts::SdoAbort>();
    // A device without PDOs in a direction needs no assignment object for it.
    if (known.empty() && abort.code == wire::SdoAbort::kObjectDoesNotExist) return pdos;
    notes_.push_back({error.slave, notes::PdosFromDescription{abort.object, abort.code, number,
                                                              static_cast<std::uint16_t>(pdos.size())}});
    return pdos;
  }

  [[nodiscard]] Use use_of(const SyncManagerPlace& place) const {
    return slaves_[place.slave].description.sync_managers[place.sync_manager].use;
  }

  std::span<const SlaveInfo> slaves_;
  StartupNotes& notes_;
  std::vector<Result<motion::PdoConfiguration>> results_;
};

using Mapping = Result<std::vector<motion::MappedObject>>;

/// The mapping that was read, or that of the description when the slave does not show its own.
Mapping take_mapping(ListRead<std::uint32_t>& list, const SlaveInfo& slave, StartupNotes& notes) {
  std::optional<Error> early;
  const auto raw = list.take(early);
  const auto failure = early ? early : raw ? std::nullopt : std::optional(raw.error());
  if (!failure) {
    std::vector<motion::MappedObject> objects;
    for (const auto object : *raw) objects.push_back(motion::MappedObject::from_raw(object));
    return objects;
  }
  const auto* abort = failure->as<facts::SdoAbort>();
  const auto known = described_mapping(slave.description, list.index());
  if (abort == nullptr || !known) return tl::unexpected(*failure);
  notes.push_back({slave.ref.position, notes::MappingFromDescription{list.index(), abort->code}});
  return *known;
}

}  // namespace

std::vector<Result<std::vector<motion::MappedObject>>> read_mappings(MailboxEngine& engine,
                                                                     std::span<const SlaveInfo> slaves,
                                                                     std::span<const PdoPlace> places,
                                                                     StartupNotes& notes) {
  std::vector<std::optional<ListRead<std::uint32_t>>> reads(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& slave = slaves[places[i].slave];
    if (slave.description.mailbox.coe) reads[i].emplace(engine, slave.ref.position, places[i].index);
  }
  for (auto& read : reads) {
    if (read) read->request_elements();
  }
  std::vector<Mapping> mappings;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& slave = slaves[places[i].slave];
    mappings.push_back(
        reads[i] ? take_mapping(*reads[i], slave, notes)
                 : described_mapping(slave.description, places[i].index).value_or(std::vector<motion::MappedObject>{}));
  }
  return mappings;
}

motion::PdoConfiguration pdo_configuration_from_sii(const esi::DeviceDescription& device) {
  const auto any = [](std::uint8_t) { return true; };
  return {described_pdos(device.rx_pdos, any), described_pdos(device.tx_pdos, any)};
}

std::vector<Result<motion::PdoConfiguration>> read_pdo_configurations(MailboxEngine& engine,
                                                                      std::span<const SlaveInfo> slaves,
                                                                      StartupNotes& notes) {
  return Discovery(slaves, notes).run(engine);
}

}  // namespace driveline::ecat_master
