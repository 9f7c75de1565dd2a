#include "eds_model_builder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "driveline/bytes/endian.hpp"
#include "driveline/esi/hex.hpp"
#include "driveline/slaves/bit_copy.hpp"
#include "driveline/slaves/pdo/pdo_map.hpp"

namespace driveline::slaves::cia301 {
namespace {

using esi::DataType;
using Fault = EdsModelError::Fault;

constexpr std::size_t kMostRpdoObjects = 0x200;        ///< 1400h to 15FFh, and likewise the others
constexpr double kExactInDouble = 9007199254740992.0;  ///< 2^53
constexpr std::size_t kWritableText = 32;              ///< shortest room of a text that can be written; ours
constexpr std::uint32_t kDoesNotExist = 0x8000'0000;   ///< bit 31 of a COB-ID
constexpr double kEventDriven = 255;                   ///< transmission type

/// A little-endian number of this type.
std::uint64_t raw_of(std::span<const std::byte> in, DataType type) {
  const auto size = std::min<std::size_t>(in.size(), byte_size(type));
  const auto raw = load_bits(in, 0, 8 * size);
  return is_signed(type) ? sign_extended(raw, 8 * size) : raw;
}

/// Whether the stack takes the entries of this object as numbers.
bool needs_number(std::uint16_t index) noexcept {
  constexpr std::array<std::uint16_t, 16> kObjects{0x1001, 0x1003, 0x1005, 0x1006, 0x1007, 0x100C, 0x100D, 0x1010,
                                                   0x1011, 0x1012, 0x1014, 0x1015, 0x1016, 0x1017, 0x1019, 0x1029};
  const bool pdo = (index >= 0x1400 && index < 0x1C00);
  return pdo || std::find(kObjects.begin(), kObjects.end(), index) != kObjects.end();
}

/// Objects whose values are no parameters: the error history, and the commands to store and to restore.
bool is_never_stored(std::uint16_t index) noexcept {
  return index == 0x1003 || index == 0x1010 || index == 0x1011;
}

bool is_mapping(std::uint16_t index) noexcept {
  return (index >= 0x1600 && index < 0x1800) || (index >= 0x1A00 && index < 0x1C00);
}

void set_limits(EntryRow& row, const esi::ObjectEntry& entry) {
  const auto limit = [&row](const std::string& hex, double& value) {
    const auto digits = esi::parse_hex(hex).value_or(std::vector<std::byte>{});
    if (digits.empty()) return;
    const double number = number_from_raw(row.type, raw_of(digits, row.type));
    if (std::abs(number) <= kExactInDouble) value = number;
  };
  limit(entry.minimum_hex, row.minimum);
  limit(entry.maximum_hex, row.maximum);
}

/// Bits of `mappable` that an entry of this object can have: parameters of the communication are no process data, and
/// no PDO contains what describes PDOs.
std::uint16_t possible_mapping(std::uint16_t index, std::uint16_t mappable) noexcept {
  if (index >= 0x2000) return mappable;
  return index < 0x1200 ? static_cast<std::uint16_t>(mappable & access::kTxMappable) : std::uint16_t{0};
}

/// Number of PDOs up to the last one that has communication parameters.
std::uint16_t count_pdos(const esi::DeviceDescription& device, std::uint16_t first) {
  std::uint16_t count = 0;
  for (const auto& object : device.objects) {
    if (object.index < first || object.index >= first + kMostRpdoObjects) continue;
    count = std::max(count, static_cast<std::uint16_t>(object.index - first + 1));
  }
  return count;
}

}  // namespace

tl::expected<void, EdsModelError> EdsModelBuilder::build() {
  const auto& device = model_.file_.device;
  for (const std::uint16_t first : {std::uint16_t{0x1400}, std::uint16_t{0x1800}}) {
    const auto count = count_pdos(device, first);
    if (count <= EdsModel::kMostPdos) continue;
    return tl::unexpected(EdsModelError{Fault::kTooManyPdos, static_cast<std::uint16_t>(first + count - 1), 0, count});
  }
  model_.options_.node_relative.clear();
  for (const auto& entry : model_.file_.node_id_defaults) count_from_node_id({entry.index, entry.subindex}, true);
  add_objects();
  apply_values();
  if (auto good = check_types(); !good) return good;
  add_facts();
  complete_pdos();
  make_mappable(0x1600, access::kRxMappable);
  make_mappable(0x1A00, access::kTxMappable);
  if (rows_.size() > EdsModel::kMostEntries) {
    return tl::unexpected(EdsModelError{Fault::kTooManyEntries, 0, 0, rows_.size()});
  }
  set_options();
  std::vector<EntryRow> list;
  for (const auto& [key, row] : rows_) list.push_back(row);
  model_.table_ =
      std::make_unique<const DictionaryTable>(std::initializer_list<std::span<const EntryRow>>{list}, std::uint16_t{0});
  name_entries(0x1A00, model_.inputs_);
  name_entries(0x1600, model_.outputs_);
  return check_mappings();
}

/// A file may have anything as the type of an entry that a service reads.
tl::expected<void, EdsModelError> EdsModelBuilder::check_types() const {
  for (const auto& [key, row] : rows_) {
    if (!needs_number(row.index) || !is_string(row.type)) continue;
    return tl::unexpected(EdsModelError{Fault::kNoNumber, row.index, row.subindex, 0});
  }
  return {};
}

/// The stack relies on mappings that a master could have written.
tl::expected<void, EdsModelError> EdsModelBuilder::check_mappings() const {
  const ObjectDictionary dictionary(*model_.table_);
  for (const EntryRow& row : model_.table_->rows()) {
    if (!is_mapping(row.index) || row.subindex != 0) continue;
    if (check_pdo_write(dictionary, model_.options_.mapping, row, dictionary.raw(row))) continue;
    return tl::unexpected(EdsModelError{Fault::kImpossibleMapping, row.index, row.subindex, 0});
  }
  return {};
}

template <typename Use>
void EdsModelBuilder::for_each_mapped(std::uint16_t mapping, const Use& use) {
  const EntryRow* count = find(mapping, 0);
  if (count == nullptr) return;
  for (std::uint64_t sub = 1; sub <= std::min<std::uint64_t>(initial_raw(*count), 64); ++sub) {
    const EntryRow* mapped = find(mapping, static_cast<std::uint8_t>(sub));
    const std::uint64_t value = mapped == nullptr ? 0 : initial_raw(*mapped);
    EntryRow* entry = find(static_cast<std::uint16_t>(value >> 16U), static_cast<std::uint8_t>(value >> 8U));
    if (entry != nullptr) use(*count, *entry);
  }
}

/// Files forget PDOMapping at entries that their own PDOs have.
void EdsModelBuilder::make_mappable(std::uint16_t first, std::uint16_t mappable) {
  for (std::uint16_t n = 0; n < EdsModel::kMostPdos; ++n) {
    for_each_mapped(static_cast<std::uint16_t>(first + n), [mappable](const EntryRow& /*pdo*/, EntryRow& entry) {
      const auto possible = possible_mapping(entry.index, mappable);
      if (possible == 0) return;
      entry.access = static_cast<std::uint16_t>((entry.access | possible) & ~unsigned{access::kBackup});
    });
  }
}

void EdsModelBuilder::name_entries(std::uint16_t first, std::vector<EdsModel::NamedEntry>& entries) {
  for (std::uint16_t n = 0; n < EdsModel::kMostPdos; ++n) {
    for_each_mapped(static_cast<std::uint16_t>(first + n), [&](const EntryRow& pdo, const EntryRow& entry) {
      const EntryRow* row = model_.table_->find(entry.index, entry.subindex);
      if (row == nullptr || is_string(row->type)) return;
      const bool known = std::any_of(entries.begin(), entries.end(), [row](const auto& one) { return one.row == row; });
      const std::string name(entry.name);
      if (!known) entries.push_back({fmt::format("{}/{}", pdo.name, name), name, row});
    });
  }
}

EntryRow* EdsModelBuilder::find(std::uint16_t index, std::uint8_t subindex) {
  const auto found = rows_.find({index, subindex});
  return found == rows_.end() ? nullptr : &found->second;
}

bool EdsModelBuilder::has_value(const EntryRow& row) const {
  const auto found = given_.find({row.index, row.subindex});
  return found != given_.end() && found->second;
}

bool EdsModelBuilder::counts_from_node_id(Address address) const {
  const auto& list = model_.options_.node_relative;
  return std::find(list.begin(), list.end(), address) != list.end();
}

void EdsModelBuilder::count_from_node_id(Address address, bool counts) {
  auto& list = model_.options_.node_relative;
  std::erase(list, address);
  if (counts) list.push_back(address);
}

void EdsModelBuilder::add_objects() {
  for (const auto& object : model_.file_.device.objects) {
    for (const auto& entry : object.entries) {
      rows_[{object.index, entry.subindex}] = row_of(object, entry);
      given_[{object.index, entry.subindex}] = !entry.default_hex.empty();
    }
  }
}

EntryRow EdsModelBuilder::row_of(const esi::Object& object, const esi::ObjectEntry& entry) {
  EntryRow row{.index = object.index, .subindex = entry.subindex, .code = object.code, .type = entry.type};
  const auto mappable =
      possible_mapping(object.index, static_cast<std::uint16_t>((entry.rx_mappable ? access::kRxMappable : 0U) |
                                                                (entry.tx_mappable ? access::kTxMappable : 0U)));
  row.access = static_cast<std::uint16_t>((entry.readable ? access::kRead : 0U) |
                                          (entry.writable ? access::kWrite : 0U) | mappable);
  const bool process_data = mappable != 0;
  if (entry.writable && !process_data && !is_never_stored(object.index)) row.access |= access::kBackup;
  row.name = &entry == &object.entries.front() ? object.name : entry.name;
  if (is_string(row.type)) {
    std::size_t length = entry.default_hex.size() / 2;
    if (entry.writable) length = std::max(length, kWritableText);
    row.string_length = static_cast<std::uint16_t>(std::min<std::size_t>(length, 0xFFFF));
    if (row.type != DataType::kVisibleString) row.type = DataType::kOctetString;
  } else {
    set_limits(row, entry);
  }
  set_initial(row, entry.default_hex);
  return row;
}

void EdsModelBuilder::set_initial(EntryRow& row, const std::string& hex) {
  const auto bytes = esi::parse_hex(hex).value_or(std::vector<std::byte>{});
  if (bytes.empty()) return;
  std::string text;
  if (is_string(row.type)) {
    for (const auto byte : bytes) text += static_cast<char>(byte);
    text.resize(std::min<std::size_t>(text.size(), row.string_length));
    if (row.type == DataType::kVisibleString) text.resize(std::min(text.size(), text.find('\0')));
  } else {
    const auto raw = raw_of(bytes, row.type);
    row.initial = number_from_raw(row.type, raw);
    const bool exact = std::abs(row.initial) < kExactInDouble && std::isfinite(row.initial);
    if (byte_size(row.type) < sizeof raw || exact) return;
    for (const auto byte : bytes::to_le_bytes(raw)) text += static_cast<char>(byte);
  }
  row.text = keep(std::move(text));
}

/// Values of a DCF replace the defaults.
void EdsModelBuilder::apply_values() {
  for (const auto& value : model_.file_.values) {
    EntryRow* row = find(value.entry.index, value.entry.subindex);
    if (row == nullptr) continue;
    const std::size_t length = value.hex.size() / 2;
    if (is_string(row->type) && length > row->string_length) {
      row->string_length = static_cast<std::uint16_t>(std::min<std::size_t>(length, 0xFFFF));
    }
    row->text = {};
    set_initial(*row, value.hex);
    given_[{row->index, row->subindex}] = true;
    count_from_node_id({row->index, row->subindex}, value.adds_node_id);
  }
}

/// Identity of [DeviceInfo] where the objects have none, and COB-IDs of CiA 301 where the file has none.
void EdsModelBuilder::add_facts() {
  const auto& device = model_.file_.device;
  const auto fill = [this](std::uint16_t index, std::uint8_t subindex, std::uint32_t value) {
    EntryRow* row = find(index, subindex);
    if (row == nullptr || has_value(*row) || is_string(row->type)) return false;
    row->initial = value;
    return true;
  };
  fill(0x1018, 1, device.vendor_id);
  fill(0x1018, 2, device.product_code);
  fill(0x1018, 3, device.revision);
  fill(0x1005, 0, canopen::predefined::kSync);
  if (fill(0x1014, 0, canopen::predefined::kEmergency)) count_from_node_id({0x1014, 0}, true);
  if (fill(0x1200, 1, canopen::predefined::kSdoClientToServer)) count_from_node_id({0x1200, 1}, true);
  if (fill(0x1200, 2, canopen::predefined::kSdoServerToClient)) count_from_node_id({0x1200, 2}, true);
}

void EdsModelBuilder::complete_pdos() {
  constexpr std::uint32_t kFirstRpdo = 0x200;
  constexpr std::uint32_t kFirstTpdo = 0x180;
  for (std::size_t n = 0; n < EdsModel::kMostPdos; ++n) {
    complete_pdo(static_cast<std::uint16_t>(0x1400 + n), n, kFirstRpdo);
    complete_pdo(static_cast<std::uint16_t>(0x1800 + n), n, kFirstTpdo);
  }
}

/// A PDO of which the file does not say its COB-ID must not have the identifier 0, which is that of NMT.
void EdsModelBuilder::complete_pdo(std::uint16_t communication, std::size_t number, std::uint32_t first_cob_id) {
  constexpr std::size_t kPredefined = 4;
  EntryRow* cob_id = find(communication, 1);
  const Address address{communication, 1};
  if (cob_id != nullptr && !is_string(cob_id->type) && initial_raw(*cob_id) == 0 && !counts_from_node_id(address)) {
    const bool predefined = number < kPredefined;
    cob_id->initial = predefined ? static_cast<double>(first_cob_id + 0x100 * number) : kDoesNotExist;
    if (predefined) count_from_node_id(address, true);
  }
  EntryRow* type = find(communication, 2);
  if (type != nullptr && !is_string(type->type) && !has_value(*type)) type->initial = kEventDriven;
}

void EdsModelBuilder::set_options() {
  auto& options = model_.options_;
  const auto& device = model_.file_.device;
  options.rpdos = count_pdos(device, 0x1400);
  options.tpdos = count_pdos(device, 0x1800);
  options.remote_types = true;  // no EDS says whether the device answers them; this one does
  std::size_t objects = options.mapping.objects;
  for (const auto& object : device.objects) {
    if (is_mapping(object.index)) objects = std::max<std::size_t>(objects, object.entries.back().subindex);
  }
  options.mapping.objects = static_cast<std::uint8_t>(std::min<std::size_t>(objects, 64));
  options.mapping.pdos = EdsModel::kMostPdos;
  std::erase_if(options.node_relative, [this](const Address& address) {
    const EntryRow* row = find(address.index, address.subindex);
    return row == nullptr || is_string(row->type);
  });
}

}  // namespace driveline::slaves::cia301
