#include "driveline/ecat_master/configuration/pdo_discovery.hpp"

#include <algorithm>
#include <optional>

#include "driveline/ecat_master/configuration/idn_mapping.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;

bool carries_process_data(Use use) {
  return use == Use::kOutputs || use == Use::kInputs;
}

/// A list object of a slave: number of elements, then the elements.
struct ListRead {
  std::size_t slave = 0;
  std::uint8_t sync_manager = 0;
  std::uint16_t index = 0;
  SdoFuture count;
  std::vector<SdoFuture> elements{};
};

template <typename T>
Result<T> value_of(const SdoFuture& future, std::uint16_t position, std::uint16_t index, std::uint8_t subindex) {
  const auto& data = future.get();
  if (!data) return tl::unexpected(data.error());
  if (data->size() == sizeof(T)) return wire::load_le<T>(*data);
  return tl::unexpected(Error{
      facts::SdoSize{
          .object = {index, subindex}, .expected = sizeof(T), .received = static_cast<std::uint32_t>(data->size())},
      position});
}

bool does_not_exist(const Error& error) {
  const auto* abort = error.as<facts::SdoAbort>();
  return abort != nullptr && abort->code == wire::SdoAbort::kObjectDoesNotExist;
}

class Reader {
 public:
  Reader(MailboxEngine& engine, std::span<const SlaveInfo> slaves) : engine_(engine), slaves_(slaves) {
    results_.resize(slaves.size());
  }

  std::vector<Result<PdoConfiguration>> run() {
    std::vector<ListRead> assignments;
    for (std::size_t i = 0; i < slaves_.size(); ++i) {
      const auto& device = slaves_[i].description;
      if (!device.mailbox.coe) {
        results_[i] = maps_by_idn(device) ? read_idn_mapping(engine_, slaves_[i]) : pdo_configuration_from_sii(device);
        continue;
      }
      for (std::size_t n = 0; n < device.sync_managers.size(); ++n) {
        if (!carries_process_data(device.sync_managers[n].use)) continue;
        assignments.push_back(
            start_list(i, static_cast<std::uint8_t>(n), static_cast<std::uint16_t>(kPdoAssignment + n)));
      }
    }
    for (auto& list : assignments) read_elements(list, true);
    std::vector<ListRead> mappings;
    for (auto& list : assignments) take_assignment(list, mappings);
    for (auto& list : mappings) read_elements(list, false);
    for (auto& list : mappings) take_mapping(list);
    return std::move(results_);
  }

 private:
  [[nodiscard]] std::uint16_t position(std::size_t slave) const { return slaves_[slave].ref.position; }

  ListRead start_list(std::size_t slave, std::uint8_t sync_manager, std::uint16_t index) {
    CoeClient coe(engine_, position(slave));
    return {slave, sync_manager, index, coe.start_upload({index, 0, false})};
  }

  void fail(const ListRead& list, const Error& error) {
    if (results_[list.slave]) results_[list.slave] = tl::unexpected(error);
  }

  /// Waits for the count and requests all elements.
  void read_elements(ListRead& list, bool may_be_missing) {
    const auto count = value_of<std::uint8_t>(list.count, position(list.slave), list.index, 0);
    if (!count) {
      // A slave without the assignment object has the PDOs of its EEPROM.
      if (may_be_missing && does_not_exist(count.error())) {
        results_[list.slave] = pdo_configuration_from_sii(slaves_[list.slave].description);
      } else {
        fail(list, count.error());
      }
      return;
    }
    CoeClient coe(engine_, position(list.slave));
    for (unsigned n = 1; n <= *count; ++n) {
      list.elements.push_back(coe.start_upload({list.index, static_cast<std::uint8_t>(n), false}));
    }
  }

  void take_assignment(const ListRead& list, std::vector<ListRead>& mappings) {
    for (std::size_t n = 0; n < list.elements.size(); ++n) {
      const auto pdo =
          value_of<std::uint16_t>(list.elements[n], position(list.slave), list.index, static_cast<std::uint8_t>(n + 1));
      if (!pdo) return fail(list, pdo.error());
      // Some slaves fill unused entries of the assignment with zeros.
      if (*pdo != 0) mappings.push_back(start_list(list.slave, list.sync_manager, *pdo));
    }
  }

  void take_mapping(const ListRead& list) {
    auto& result = results_[list.slave];
    PdoMapping pdo;
    pdo.index = list.index;
    pdo.sync_manager = list.sync_manager;
    for (std::size_t n = 0; n < list.elements.size(); ++n) {
      const auto raw =
          value_of<std::uint32_t>(list.elements[n], position(list.slave), list.index, static_cast<std::uint8_t>(n + 1));
      if (!raw) return fail(list, raw.error());
      pdo.objects.push_back({static_cast<std::uint16_t>(*raw >> 16), static_cast<std::uint8_t>(*raw >> 8),
                             static_cast<std::uint8_t>(*raw)});
    }
    if (!result) return;
    const auto use = slaves_[list.slave].description.sync_managers[list.sync_manager].use;
    (use == Use::kOutputs ? result->outputs : result->inputs).push_back(std::move(pdo));
  }

  MailboxEngine& engine_;
  std::span<const SlaveInfo> slaves_;
  std::vector<Result<PdoConfiguration>> results_;
};

std::vector<MappedObject> described_objects(const esi::Pdo& pdo) {
  std::vector<MappedObject> objects;
  for (const auto& entry : pdo.entries) objects.push_back({entry.index, entry.subindex, entry.bit_length});
  return objects;
}

std::vector<MappedObject> described_mapping(const esi::DeviceDescription& device, std::uint16_t index) {
  for (const auto* pdos : {&device.rx_pdos, &device.tx_pdos}) {
    const auto found = std::find_if(pdos->begin(), pdos->end(), [=](const auto& pdo) { return pdo.index == index; });
    if (found != pdos->end()) return described_objects(*found);
  }
  return {};
}

using Mapping = Result<std::vector<MappedObject>>;

/// Reads the mapping of a PDO over CoE.
class MappingRead {
 public:
  MappingRead(MailboxEngine& engine, std::uint16_t position, std::uint16_t pdo)
      : coe_(engine, position), position_(position), pdo_(pdo), count_(coe_.start_upload({pdo, 0, false})) {}

  /// Waits for the count and requests all entries.
  void ask_entries() {
    const auto count = value_of<std::uint8_t>(count_, position_, pdo_, 0);
    for (unsigned n = 1; n <= count.value_or(0); ++n) {
      entries_.push_back(coe_.start_upload({pdo_, static_cast<std::uint8_t>(n), false}));
    }
    if (!count) mapping_ = tl::unexpected(count.error());
  }
  Mapping take() {
    for (std::size_t n = 0; mapping_ && n < entries_.size(); ++n) {
      const auto raw = value_of<std::uint32_t>(entries_[n], position_, pdo_, static_cast<std::uint8_t>(n + 1));
      if (raw) {
        mapping_->push_back(MappedObject::from_raw(*raw));
      } else {
        mapping_ = tl::unexpected(raw.error());
      }
    }
    return std::move(mapping_);
  }

 private:
  CoeClient coe_;
  std::uint16_t position_;
  std::uint16_t pdo_;
  SdoFuture count_;
  std::vector<SdoFuture> entries_;
  Mapping mapping_;
};

}  // namespace

std::vector<Result<std::vector<MappedObject>>> read_mappings(MailboxEngine& engine, std::span<const SlaveInfo> slaves,
                                                             std::span<const PdoPlace> places) {
  std::vector<std::optional<MappingRead>> reads(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& slave = slaves[places[i].slave];
    if (slave.description.mailbox.coe) reads[i].emplace(engine, slave.ref.position, places[i].index);
  }
  for (auto& read : reads) {
    if (read) read->ask_entries();
  }
  std::vector<Mapping> mappings;
  for (std::size_t i = 0; i < places.size(); ++i) {
    mappings.push_back(reads[i] ? reads[i]->take()
                                : described_mapping(slaves[places[i].slave].description, places[i].index));
  }
  return mappings;
}

PdoConfiguration pdo_configuration_from_sii(const esi::DeviceDescription& device) {
  PdoConfiguration configuration;
  auto take = [](const std::vector<esi::Pdo>& pdos, std::vector<PdoMapping>& mappings) {
    for (const auto& pdo : pdos) {
      if (!pdo.sync_manager) continue;
      PdoMapping mapping;
      mapping.index = pdo.index;
      mapping.sync_manager = *pdo.sync_manager;
      mapping.objects = described_objects(pdo);
      mappings.push_back(std::move(mapping));
    }
  };
  take(device.rx_pdos, configuration.outputs);
  take(device.tx_pdos, configuration.inputs);
  return configuration;
}

std::vector<Result<PdoConfiguration>> read_pdo_configurations(MailboxEngine& engine,
                                                              std::span<const SlaveInfo> slaves) {
  return Reader(engine, slaves).run();
}

}  // namespace driveline::ecat_master
