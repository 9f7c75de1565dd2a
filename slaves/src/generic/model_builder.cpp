#include "model_builder.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "driveline/bytes/endian.hpp"
#include "driveline/esi/hex.hpp"
#include "driveline/slaves/bit_copy.hpp"
#include "driveline/slaves/sync_demand.hpp"

namespace driveline::slaves::generic {
namespace {

using esi::DataType;
using esi::ObjectCode;
using Use = esi::SyncManager::Use;

constexpr std::uint16_t kPdoMappingRecord = 0x0021;  ///< data types of records, ETG.1000.6 Table 64
constexpr std::uint16_t kIdentityRecord = 0x0023;
constexpr std::uint16_t kSyncManagerRecord = 0x0029;
constexpr std::size_t kMappingEntries = 16;            ///< entries of a PDO whose mapping the master may write
constexpr std::uint16_t kMaxPdoBytes = 1486;           ///< process data of a frame
constexpr std::size_t kMaxRows = 0xFF00;               ///< slot numbers have 16 bits
constexpr std::uint16_t kMaxPdos = 0x200;              ///< 1600h-17FFh, 1A00h-1BFFh
constexpr double kExactInDouble = 9007199254740992.0;  ///< 2^53
constexpr std::uint32_t kMinCycleNs = 125'000;

/// Returns the little-endian number in the first bytes, interpreted by its type.
std::uint64_t number_of(std::span<const std::byte> bytes, const EntryRow& row) {
  const auto count = std::min<std::size_t>(bytes.size(), byte_size(row.type));
  const auto raw = load_bits(bytes, 0, std::min(8 * count, bit_size(row)));
  return is_signed(row.type) ? sign_extended(raw, std::min(8 * count, bit_size(row))) : raw;
}

bool is_pdo_object(std::uint16_t index) {
  return (index >= 0x1600 && index < 0x1800) || (index >= 0x1A00 && index < 0x1C00);
}

bool is_configuration(std::uint16_t index) {
  return is_pdo_object(index) || (index >= 0x1C10 && index < 0x1C30);
}

std::uint32_t mapping_value(const esi::PdoEntry& entry) {
  return static_cast<std::uint32_t>(entry.index) << 16 | static_cast<std::uint32_t>(entry.subindex) << 8 |
         entry.bit_length;
}

}  // namespace

bool ModelBuilder::has_object(std::uint16_t index) const {
  const auto found = rows_.lower_bound({index, 0});
  return found != rows_.end() && found->first.first == index;
}

void ModelBuilder::erase_object(std::uint16_t index) {
  rows_.erase(rows_.lower_bound({index, 0}), rows_.upper_bound({index, 0xFF}));
}

tl::expected<void, DeviceModelError> ModelBuilder::build() {
  auto& limits = model_.limits_;
  limits = {.pdos = kMaxPdos, .objects = 0xFF, .bytes = kMaxPdoBytes, .gaps = true};
  limits.output_sync_managers = limits.input_sync_managers = 0;
  for (std::size_t n = 0; n < device_.sync_managers.size(); ++n) {
    if (device_.sync_managers[n].use == Use::kOutputs) limits.output_sync_managers |= 1U << n;
    if (device_.sync_managers[n].use == Use::kInputs) limits.input_sync_managers |= 1U << n;
  }
  if (device_.mailbox.coe) add_described_objects();
  add_pdos(device_.rx_pdos, access::kRxMappable);
  add_pdos(device_.tx_pdos, access::kTxMappable);
  add_sync_manager_objects();
  if (device_.mailbox.coe) add_device_facts();
  complete_records();
  if (rows_.size() > kMaxRows) {
    return tl::unexpected(TooManyEntries{rows_.size(), kMaxRows});
  }
  settle_slots();
  std::vector<EntryRow> list;
  for (const auto& [address, row] : rows_) list.push_back(row);
  model_.table_ =
      std::make_unique<const DictionaryTable>(std::initializer_list<std::span<const EntryRow>>{list}, std::uint16_t{0});
  return {};
}

void ModelBuilder::add_described_objects() {
  for (const auto& object : device_.objects) {
    for (const auto& entry : object.entries) put(described_row(object, entry));
  }
}

EntryRow ModelBuilder::described_row(const esi::Object& object, const esi::ObjectEntry& entry) {
  EntryRow row{.index = object.index, .subindex = entry.subindex, .code = object.code, .type = entry.type};
  row.access = static_cast<std::uint16_t>((entry.readable ? access::kRead : 0U) |
                                          (entry.rx_mappable ? access::kRxMappable : 0U) |
                                          (entry.tx_mappable ? access::kTxMappable : 0U));
  if (entry.writable) row.access |= is_configuration(object.index) ? access::kWriteConfiguring : access::kWrite;
  row.name = &entry == &object.entries.front() ? object.name : entry.name;
  if (entry.bit_offset) row.bit_offset = *entry.bit_offset;
  // A number that is longer than its type is stored as bytes.
  if (entry.bit_length > 8 * byte_size(row.type) && !is_string(row.type)) row.type = DataType::kOctetString;
  if (is_string(row.type)) {
    row.string_length = static_cast<std::uint16_t>((entry.bit_length + 7U) / 8U);
    if (row.type != DataType::kVisibleString) row.type = DataType::kOctetString;
    if (entry.bit_length % 8 != 0) row.bit_length = entry.bit_length;
  } else if (entry.bit_length != 0 && entry.bit_length != bit_size(row)) {
    row.bit_length = entry.bit_length;
  }
  set_default(row, entry.default_hex);
  if (is_string(row.type)) return row;
  const auto limit = [&row](const std::string& hex, double& value) {
    const auto bytes = esi::parse_hex(hex).value_or(std::vector<std::byte>{});
    if (bytes.empty()) return;
    const double number = number_from_raw(row.type, number_of(bytes, row));
    if (std::abs(number) <= kExactInDouble) value = number;
  };
  limit(entry.minimum_hex, row.minimum);
  limit(entry.maximum_hex, row.maximum);
  return row;
}

void ModelBuilder::set_default(EntryRow& row, const std::string& hex) {
  auto bytes = esi::parse_hex(hex).value_or(std::vector<std::byte>{});
  if (bytes.empty()) return;
  if (!is_string(row.type)) {
    const auto raw = number_of(bytes, row);
    row.initial = number_from_raw(row.type, raw);
    if (byte_size(row.type) < sizeof raw || (std::abs(row.initial) < kExactInDouble && std::isfinite(row.initial))) {
      return;
    }
    const auto exact = bytes::to_le_bytes(raw);
    bytes.assign(exact.begin(), exact.end());
  }
  std::string text;
  for (const auto byte : bytes) text += static_cast<char>(byte);
  if (is_string(row.type)) text.resize(std::min<std::size_t>(text.size(), row.string_length));
  if (row.type == DataType::kVisibleString) text.resize(std::min(text.size(), text.find('\0')));
  row.text = keep(std::move(text));
}

void ModelBuilder::add_pdos(const std::vector<esi::Pdo>& pdos, std::uint16_t mappable) {
  std::set<std::uint16_t> seen;
  for (const auto& pdo : pdos) {
    if (!is_pdo_object(pdo.index) || !seen.insert(pdo.index).second)
      continue;  // of two PDOs with the same index, the first is used
    for (const auto& entry : pdo.entries) add_pdo_entry(entry, mappable);
    add_mapping(pdo);
  }
}

void ModelBuilder::add_pdo_entry(const esi::PdoEntry& entry, std::uint16_t mappable) {
  if (entry.index == 0 || entry.bit_length == 0) return;
  if (const auto found = rows_.find({entry.index, entry.subindex}); found != rows_.end()) {
    found->second.access |= mappable;
    return;
  }
  EntryRow row{.index = entry.index, .subindex = entry.subindex, .code = ObjectCode::kRecord, .type = entry.type};
  row.access =
      static_cast<std::uint16_t>(mappable | access::kRead | (mappable == access::kRxMappable ? access::kWrite : 0U));
  row.name = entry.name;
  if (is_string(row.type) || entry.bit_length > 8 * byte_size(row.type)) {
    row.type = row.type == DataType::kVisibleString ? row.type : DataType::kOctetString;
    row.string_length = static_cast<std::uint16_t>((entry.bit_length + 7U) / 8U);
    if (entry.bit_length % 8 != 0) row.bit_length = entry.bit_length;
  } else if (entry.bit_length != bit_size(row)) {
    row.bit_length = entry.bit_length;
  }
  put(row);
}

/// 1600h.., 1A00h..: content of the PDO. The master may write it when the device supports that.
void ModelBuilder::add_mapping(const esi::Pdo& pdo) {
  erase_object(pdo.index);
  const bool fixed = pdo.fixed || !device_.mailbox.coe_pdo_config;
  const auto mapped = std::min<std::size_t>(pdo.entries.size(), 0xFF);
  const auto entries = fixed ? mapped : std::max(mapped, kMappingEntries);
  EntryRow row{.index = pdo.index,
               .code = ObjectCode::kRecord,
               .type = DataType::kUnsigned8,
               .access = fixed ? access::kRead : access::kReadWriteConfiguring,
               .name = pdo.name,
               .initial = static_cast<double>(mapped),
               .record_type = kPdoMappingRecord};
  put(row);
  row.type = DataType::kUnsigned32;
  row.record_type = 0;
  for (std::size_t i = 0; i < entries; ++i) {
    row.subindex = static_cast<std::uint8_t>(i + 1);
    row.name = i < mapped ? std::string_view(pdo.entries[i].name) : "Mapped object";
    row.initial = i < mapped ? mapping_value(pdo.entries[i]) : 0;
    put(row);
  }
  model_.max_fields_ += entries;
}

void ModelBuilder::add_sync_manager_objects() {
  const auto& managers = device_.sync_managers;
  EntryRow row{.index = 0x1C00,
               .code = ObjectCode::kArray,
               .type = DataType::kUnsigned8,
               .name = "Sync manager communication type",
               .initial = static_cast<double>(managers.size())};
  erase_object(row.index);
  if (device_.mailbox.coe) put(row);
  for (std::size_t n = 0; n < managers.size(); ++n) {
    row.subindex = static_cast<std::uint8_t>(n + 1);
    row.name = keep("Sync manager " + std::to_string(n));
    row.initial = static_cast<double>(managers[n].use);
    if (device_.mailbox.coe) put(row);
    if (managers[n].use != Use::kOutputs && managers[n].use != Use::kInputs) continue;
    add_assignment(n, managers[n].use == Use::kOutputs ? device_.rx_pdos : device_.tx_pdos);
    if (device_.mailbox.coe) add_synchronisation(n);
  }
}

/// 1C10h + n: PDOs of a sync manager, initially the PDOs that specify this sync manager.
void ModelBuilder::add_assignment(std::size_t number, const std::vector<esi::Pdo>& pdos) {
  std::vector<std::uint16_t> assigned;
  for (const auto& pdo : pdos) {
    const bool twice = std::find(assigned.begin(), assigned.end(), pdo.index) != assigned.end();
    if (pdo.sync_manager == number && is_pdo_object(pdo.index) && !twice) assigned.push_back(pdo.index);
  }
  const auto count = std::min<std::size_t>(assigned.size(), 0xFE);
  const bool free = device_.mailbox.coe_pdo_assign;
  const auto entries = free ? std::clamp<std::size_t>(pdos.size(), 1, 0xFE) : count;
  EntryRow row{.index = assignment_object(number),
               .code = ObjectCode::kArray,
               .type = DataType::kUnsigned8,
               .access = free ? access::kReadWriteConfiguring : access::kRead,
               .name = "PDO assignment",
               .initial = static_cast<double>(count)};
  erase_object(row.index);
  put(row);
  row.type = DataType::kUnsigned16;
  row.name = "Assigned PDO";
  for (std::size_t i = 0; i < entries; ++i) {
    row.subindex = static_cast<std::uint8_t>(i + 1);
    row.initial = i < count ? assigned[i] : 0;
    put(row);
  }
}

/// 1C30h + n (ETG.1020, synchronisation): free run, SM event, or SYNC0 when the device has DC modes; inputs of a device
/// with outputs may follow their event (22h).
void ModelBuilder::add_synchronisation(std::size_t number) {
  EntryRow row{.index = sync_parameter_object(number),
               .code = ObjectCode::kRecord,
               .type = DataType::kUnsigned8,
               .name = "Sync manager parameter",
               .initial = 6,
               .record_type = kSyncManagerRecord};
  if (has_object(row.index)) return;
  put(row);
  const bool dc = !device_.dc_modes.empty();
  const auto entry = [&](std::uint8_t subindex, DataType type, std::string_view name, double value) -> EntryRow& {
    return put({.index = row.index,
                .subindex = subindex,
                .code = ObjectCode::kRecord,
                .type = type,
                .name = name,
                .initial = value});
  };
  auto& type = entry(1, DataType::kUnsigned16, "Synchronisation type", 0);
  type.access = access::kReadWriteConfiguring;
  const bool after_outputs = device_.sync_managers[number].use == Use::kInputs && !device_.rx_pdos.empty();
  type.maximum = static_cast<double>(after_outputs ? SyncType::kSm2Event : SyncType::kSync1);
  entry(2, DataType::kUnsigned32, "Cycle time", kMinCycleNs).access = access::kReadWriteConfiguring;
  entry(3, DataType::kUnsigned32, "Shift time", 0);
  entry(4, DataType::kUnsigned16, "Synchronisation types supported", dc ? 0x0007 : 0x0003);
  entry(5, DataType::kUnsigned32, "Minimum cycle time", kMinCycleNs);
  entry(6, DataType::kUnsigned32, "Calc and copy time", 0);
}

/// 1000h, 1008h-100Ah, 1018h: the identity is that of the EEPROM, even if the dictionary differs.
void ModelBuilder::add_device_facts() {
  if (!has_object(0x1000)) {
    put({.index = 0x1000, .name = "Device type", .initial = static_cast<double>(device_.device_profile)});
  }
  const auto text = [this](std::uint16_t index, std::string_view name, std::string value) {
    if (has_object(index)) return;
    const std::string_view kept = keep(std::move(value));
    put({.index = index,
         .type = DataType::kVisibleString,
         .name = name,
         .text = kept,
         .string_length = static_cast<std::uint16_t>(std::min<std::size_t>(kept.size(), 0xFFFF))});
  };
  text(0x1008, "Manufacturer device name", device_.name.empty() ? device_.type : device_.name);
  text(0x1009, "Manufacturer hardware version", "simulation");
  text(0x100A, "Manufacturer software version", "simulation");
  erase_object(0x1018);
  EntryRow row{.index = 0x1018,
               .code = ObjectCode::kRecord,
               .type = DataType::kUnsigned8,
               .name = "Identity",
               .initial = 4,
               .record_type = kIdentityRecord};
  put(row);
  row.type = DataType::kUnsigned32;
  row.record_type = 0;
  const auto entry = [&](std::uint8_t subindex, std::string_view name, std::uint32_t value) {
    row.subindex = subindex;
    row.name = name;
    row.initial = value;
    put(row);
  };
  entry(1, "Vendor ID", device_.vendor_id);
  entry(2, "Product code", device_.product_code);
  entry(3, "Revision number", device_.revision);
  entry(4, "Serial number", device_.serial_number);
}

/// Objects that only PDOs refer to are variables or records; records get an entry 0.
void ModelBuilder::complete_records() {
  std::map<std::uint16_t, EntryRow> missing;
  for (auto it = rows_.begin(); it != rows_.end();) {
    const auto index = it->first.first;
    const auto end = rows_.upper_bound({index, 0xFF});
    const auto last = std::prev(end)->first.second;
    const auto code = last == 0                                  ? ObjectCode::kVariable
                      : it->second.code == ObjectCode::kVariable ? ObjectCode::kRecord
                                                                 : it->second.code;
    if (it->first.second != 0) {
      missing[index] = {.index = index,
                        .code = code,
                        .type = DataType::kUnsigned8,
                        .name = it->second.name,
                        .initial = static_cast<double>(last)};
    }
    for (; it != end; ++it) it->second.code = code;
  }
  for (const auto& [index, row] : missing) put(row);
}

/// Marks constant numbers, which need no slot of their own.
void ModelBuilder::settle_slots() {
  constexpr std::uint16_t kChanges = access::kWrite | access::kRxMappable | access::kTxMappable;
  for (auto& [address, row] : rows_) {
    const bool serial = address == Address{0x1018, 4};
    if (!is_string(row.type) && (row.access & kChanges) == 0 && !serial) row.slot = slot::kConstant;
  }
}

}  // namespace driveline::slaves::generic
