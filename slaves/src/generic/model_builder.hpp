#pragma once

#include <map>

#include "driveline/slaves/generic/device_model.hpp"

namespace driveline::slaves::generic {

/// Creates the object dictionary of a device: the objects of its description, the entries of its PDOs, and the objects
/// of the communication area that every CoE device has (ETG.1020) and the description omits.
class ModelBuilder {
 public:
  explicit ModelBuilder(DeviceModel& model) : model_(model), device_(model.description_) {}

  [[nodiscard]] tl::expected<void, DeviceModelError> build();

 private:
  using Address = std::pair<std::uint16_t, std::uint8_t>;

  void add_described_objects();
  [[nodiscard]] EntryRow described_row(const esi::Object& object, const esi::ObjectEntry& entry);
  void set_default(EntryRow& row, const std::string& hex);
  void add_pdos(const std::vector<esi::Pdo>& pdos, std::uint16_t mappable);
  void add_pdo_entry(const esi::PdoEntry& entry, std::uint16_t mappable);
  void add_mapping(const esi::Pdo& pdo);
  void add_sync_manager_objects();
  void add_assignment(std::size_t number, const std::vector<esi::Pdo>& pdos);
  void add_synchronisation(std::size_t number);
  void add_device_facts();
  void complete_records();
  void settle_slots();

  EntryRow& put(EntryRow row) { return rows_[{row.index, row.subindex}] = row; }
  [[nodiscard]] bool has_object(std::uint16_t index) const;
  void erase_object(std::uint16_t index);
  [[nodiscard]] std::string_view keep(std::string text) { return model_.texts_.emplace_back(std::move(text)); }

  DeviceModel& model_;
  const esi::DeviceDescription& device_;
  std::map<Address, EntryRow> rows_;
};

}  // namespace driveline::slaves::generic
