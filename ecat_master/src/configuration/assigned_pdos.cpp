#include "configuration/assigned_pdos.hpp"

#include <algorithm>
#include <optional>

#include "configuration/list_read.hpp"

namespace driveline::ecat_master {
namespace {

/// A mapping that is being read, and the place whose assignment has it.
struct MappingOfPlace {
  std::size_t place = 0;
  ListRead<std::uint32_t> list;
};

class AssignmentReader {
 public:
  AssignmentReader(MailboxEngine& engine, std::span<const SlaveInfo> slaves, std::span<const SyncManagerPlace> places,
                   StartupNotes& notes)
      : engine_(engine), slaves_(slaves), places_(places), notes_(notes), results_(places.size()) {}

  std::vector<Result<std::vector<motion::PdoMapping>>> run() {
    std::vector<ListRead<std::uint16_t>> assignments;
    for (const auto& place : places_) {
      assignments.emplace_back(engine_, position(place),
                               static_cast<std::uint16_t>(kPdoAssignment + place.sync_manager));
    }
    for (auto& list : assignments) list.request_elements();
    for (std::size_t i = 0; i < assignments.size(); ++i) take_assignment(i, assignments[i]);
    for (auto& mapping : mappings_) mapping.list.request_elements();
    for (auto& mapping : mappings_) take_mapping(mapping);
    return std::move(results_);
  }

 private:
  [[nodiscard]] std::uint16_t position(const SyncManagerPlace& place) const {
    return slaves_[place.slave].ref.position;
  }

  void take_assignment(std::size_t place, ListRead<std::uint16_t>& list) {
    std::optional<Error> early;
    const auto pdos = list.take(early);
    if (!pdos) {
      results_[place] = tl::unexpected(pdos.error());
      return;
    }
    if (early) {
      const auto& abort = *early->as<facts::SdoAbort>();
      notes_.push_back({early->slave, notes::ListEndsEarly{abort.object, abort.code, list.elements()}});
    }
    for (const auto pdo : *pdos) {
      // Some slaves fill unused entries of the assignment with zeros.
      if (pdo != 0) mappings_.push_back({place, {engine_, position(places_[place]), pdo}});
    }
  }

  void take_mapping(MappingOfPlace& mapping) {
    auto& result = results_[mapping.place];
    const auto& place = places_[mapping.place];
    motion::PdoMapping pdo;
    pdo.index = mapping.list.index();
    pdo.sync_manager = place.sync_manager;
    std::optional<Error> early;
    const auto raw = mapping.list.take(early);
    const auto failure = early ? early : raw ? std::nullopt : std::optional(raw.error());
    if (!failure) {
      for (const auto object : *raw) pdo.objects.push_back(motion::MappedObject::from_raw(object));
    } else if (auto known = mapping_instead(*failure, slaves_[place.slave].description, pdo.index)) {
      pdo.objects = std::move(*known);
    } else if (result) {
      result = tl::unexpected(*failure);
    }
    if (result) result->push_back(std::move(pdo));
  }

  /// The mapping of the description, when the slave refuses to show its own.
  std::optional<std::vector<motion::MappedObject>> mapping_instead(const Error& failure,
                                                                   const esi::DeviceDescription& device,
                                                                   std::uint16_t pdo) {
    const auto* abort = failure.as<facts::SdoAbort>();
    if (abort == nullptr) return std::nullopt;
    auto known = described_mapping(device, pdo);
    if (known) notes_.push_back({failure.slave, notes::MappingFromDescription{pdo, abort->code}});
    return known;
  }

  MailboxEngine& engine_;
  std::span<const SlaveInfo> slaves_;
  std::span<const SyncManagerPlace> places_;
  StartupNotes& notes_;
  std::vector<MappingOfPlace> mappings_;
  std::vector<Result<std::vector<motion::PdoMapping>>> results_;
};

}  // namespace

std::vector<Result<std::vector<motion::PdoMapping>>> read_assignments(MailboxEngine& engine,
                                                                      std::span<const SlaveInfo> slaves,
                                                                      std::span<const SyncManagerPlace> places,
                                                                      StartupNotes& notes) {
  return AssignmentReader(engine, slaves, places, notes).run();
}

std::optional<std::vector<motion::MappedObject>> described_mapping(const esi::DeviceDescription& device,
                                                                   std::uint16_t index) {
  for (const auto* pdos : {&device.rx_pdos, &device.tx_pdos}) {
    const auto found = std::find_if(pdos->begin(), pdos->end(), [=](const auto& pdo) { return pdo.index == index; });
    if (found == pdos->end()) continue;
    std::vector<motion::MappedObject> objects;
    for (const auto& entry : found->entries) objects.push_back({entry.index, entry.subindex, entry.bit_length});
    return objects;
  }
  return std::nullopt;
}

}  // namespace driveline::ecat_master
