#pragma once

#include <map>
#include <utility>

#include "driveline/slaves/canopen/eds_model.hpp"

namespace driveline::slaves::cia301 {

/// Creates the object dictionary and the settings of a device from its EDS or DCF.
class EdsModelBuilder {
 public:
  explicit EdsModelBuilder(EdsModel& model) : model_(model) {}

  [[nodiscard]] tl::expected<void, EdsModelError> build();

 private:
  using Key = std::pair<std::uint16_t, std::uint8_t>;

  void add_objects();
  [[nodiscard]] EntryRow row_of(const esi::Object& object, const esi::ObjectEntry& entry);
  void set_initial(EntryRow& row, const std::string& hex);
  void apply_values();
  void add_facts();
  void complete_pdos();
  void complete_pdo(std::uint16_t communication, std::size_t number, std::uint32_t first_cob_id);
  void set_options();
  void make_mappable(std::uint16_t first, std::uint16_t mappable);
  [[nodiscard]] tl::expected<void, EdsModelError> check_types() const;
  [[nodiscard]] tl::expected<void, EdsModelError> check_mappings() const;
  void name_entries(std::uint16_t first, std::vector<EdsModel::NamedEntry>& entries);
  /// Calls `use` with each entry that the default mapping of a PDO names.
  template <typename Use>
  void for_each_mapped(std::uint16_t mapping, const Use& use);

  [[nodiscard]] EntryRow* find(std::uint16_t index, std::uint8_t subindex);
  [[nodiscard]] bool has_value(const EntryRow& row) const;
  [[nodiscard]] bool counts_from_node_id(Address address) const;
  void count_from_node_id(Address address, bool counts);
  [[nodiscard]] std::string_view keep(std::string text) { return model_.texts_.emplace_back(std::move(text)); }

  EdsModel& model_;
  std::map<Key, EntryRow> rows_;
  std::map<Key, bool> given_;  ///< whether the file has a value of the entry
};

}  // namespace driveline::slaves::cia301
