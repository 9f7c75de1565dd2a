#include <vector>

#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/slaves/msd/msd_values.hpp"

namespace driveline::slaves::msd {
namespace {

using esi::DataType;
using esi::ObjectCode;

constexpr std::string_view kTable81 = "MSD manual Table 8.1";
constexpr std::string_view kErrorSettings = "ETG.1020 10F1h; without local error reaction";
constexpr std::string_view kEtg = "ETG.1000.6 5.6.7";
constexpr std::uint16_t kPdoMappingRecord = 0x0021;
constexpr std::uint16_t kIdentityRecord = 0x0023;
constexpr std::uint16_t kSyncManagerRecord = 0x0029;
constexpr std::uint8_t kSyncParameterLast = 0x20;

constexpr EntryRow constant(std::uint16_t index, std::uint8_t subindex, ObjectCode code, DataType type,
                            std::string_view name, double value, std::string_view source) {
  return {.index = index,
          .subindex = subindex,
          .code = code,
          .type = type,
          .slot = slot::kConstant,
          .name = name,
          .initial = value,
          .source = source};
}

constexpr std::array kSingleRows = {
    constant(0x1000, 0, ObjectCode::kVariable, DataType::kUnsigned32, "Device type", 0x00020192, kTable81),
    EntryRow{.index = 0x1001,
             .type = DataType::kUnsigned8,
             .access = access::kRead | access::kTxMappable,
             .slot = kErrorRegister,
             .name = "Error register",
             .source = kTable81},
    EntryRow{.index = 0x1003,
             .code = ObjectCode::kArray,
             .type = DataType::kUnsigned8,
             .access = access::kReadWrite,
             .slot = kErrorCount,
             .name = "Pre-defined error field",
             .maximum = 0,
             .source = "MSD manual Table 8.1: one sub-entry; CiA 301: writing 0 clears"},
    EntryRow{.index = 0x1003,
             .subindex = 1,
             .code = ObjectCode::kArray,
             .slot = kLastError,
             .name = "Last error",
             .source = "CiA 301: error code, above it number and location (ours)"},
    EntryRow{.index = 0x1008,
             .type = DataType::kVisibleString,
             .name = "Manufacturer device name",
             .text = "MSD Servo Drive",
             .string_length = 15,
             .source = kTable81},
    EntryRow{.index = 0x1009,
             .type = DataType::kVisibleString,
             .name = "Manufacturer hardware version",
             .text = "simulation",
             .string_length = 10,
             .source = "MSD manual Table 8.1; content ours"},
    EntryRow{.index = 0x100A,
             .type = DataType::kVisibleString,
             .name = "Manufacturer software version",
             .text = "124.30-00",
             .string_length = 9,
             .source = "MSD manual: applies from 124.25; format ours"},
    constant(0x1010, 0, ObjectCode::kArray, DataType::kUnsigned8, "Store parameters", 1, kTable81),
    EntryRow{.index = 0x1010,
             .subindex = 1,
             .code = ObjectCode::kArray,
             .access = access::kReadWrite,
             .slot = kStoreCommand,
             .name = "Store all parameters",
             .initial = 1,
             .source = "MSD manual 7.5.3; signature CiA 301"},
    constant(0x1011, 0, ObjectCode::kArray, DataType::kUnsigned8, "Restore default parameters", 1, kTable81),
    EntryRow{.index = 0x1011,
             .subindex = 1,
             .code = ObjectCode::kArray,
             .access = access::kReadWrite,
             .slot = kRestoreCommand,
             .name = "Restore all parameters",
             .initial = 1,
             .source = "MSD manual Table 8.1; signature CiA 301"},
    EntryRow{.index = 0x1018,
             .code = ObjectCode::kRecord,
             .type = DataType::kUnsigned8,
             .slot = slot::kConstant,
             .name = "Identity",
             .initial = 4,
             .record_type = kIdentityRecord,
             .source = kTable81},
    constant(0x1018, 1, ObjectCode::kRecord, DataType::kUnsigned32, "Vendor ID", kVendorId, kTable81),
    constant(0x1018, 2, ObjectCode::kRecord, DataType::kUnsigned32, "Product code", kProductCode, "ours"),
    constant(0x1018, 3, ObjectCode::kRecord, DataType::kUnsigned32, "Revision number", kRevision, "ours"),
    EntryRow{.index = 0x1018,
             .subindex = 4,
             .code = ObjectCode::kRecord,
             .slot = kSerialNumber,
             .name = "Serial number",
             .source = kTable81},
    constant(0x10F1, 0, ObjectCode::kRecord, DataType::kUnsigned8, "Error settings", 2, kErrorSettings),
    EntryRow{.index = 0x10F1,
             .subindex = 2,
             .code = ObjectCode::kRecord,
             .type = DataType::kUnsigned16,
             .access = access::kReadWriteConfiguring | access::kBackup,
             .slot = kSyncErrorLimit,
             .name = "Sync error counter limit",
             .initial = 30,
             .source = "ETG.1020 10F1h: a cycle without outputs counts 3, one with them -1; initial value ours"},
    constant(0x1C00, 0, ObjectCode::kArray, DataType::kUnsigned8, "Sync manager communication type", 4, kEtg),
    constant(0x1C00, 1, ObjectCode::kArray, DataType::kUnsigned8, "Sync manager 0: mailbox out", 1, kEtg),
    constant(0x1C00, 2, ObjectCode::kArray, DataType::kUnsigned8, "Sync manager 1: mailbox in", 2, kEtg),
    constant(0x1C00, 3, ObjectCode::kArray, DataType::kUnsigned8, "Sync manager 2: outputs", 3, kEtg),
    constant(0x1C00, 4, ObjectCode::kArray, DataType::kUnsigned8, "Sync manager 3: inputs", 4, kEtg),
};

/// 1600h-1603h or 1A00h-1A03h: empty by default, kept with the parameters (MSD manual 8.3.3).
void add_mappings(std::vector<EntryRow>& rows, std::uint16_t first, std::string_view name) {
  const EntryRow base{.code = ObjectCode::kRecord,
                      .access = access::kReadWriteConfiguring | access::kBackup,
                      .source = "MSD manual 8.3.3, Table 8.5"};
  for (std::uint8_t pdo = 0; pdo < kPdoLimits.pdos; ++pdo) {
    EntryRow row = base;
    row.index = static_cast<std::uint16_t>(first + pdo);
    row.type = DataType::kUnsigned8;
    row.name = name;
    row.record_type = kPdoMappingRecord;
    rows.push_back(row);
    row.type = DataType::kUnsigned32;
    row.name = "Mapped object";
    row.record_type = 0;
    for (row.subindex = 1; row.subindex <= kPdoLimits.objects; ++row.subindex) rows.push_back(row);
  }
}

/// 1C12h, 1C13h: all PDOs are assigned, in order.
void add_assignment(std::vector<EntryRow>& rows, std::uint16_t index, std::uint16_t first, std::string_view name) {
  EntryRow row{.index = index,
               .code = ObjectCode::kArray,
               .type = DataType::kUnsigned8,
               .access = access::kReadWriteConfiguring | access::kBackup,
               .name = name,
               .initial = static_cast<double>(kPdoLimits.pdos),
               .source = kEtg};
  rows.push_back(row);
  row.type = DataType::kUnsigned16;
  row.name = "Assigned PDO";
  for (std::uint8_t pdo = 0; pdo < kPdoLimits.pdos; ++pdo) {
    row.subindex = static_cast<std::uint8_t>(pdo + 1);
    row.initial = first + pdo;
    rows.push_back(row);
  }
}

/// 1C32h, 1C33h (ETG.1020 Table 80): free run, SM event or DC SYNC0, cycle from 125 us (MSD manual 9.1).
void add_synchronisation(std::vector<EntryRow>& rows, std::uint16_t index, std::string_view name,
                         std::uint8_t entries) {
  constexpr auto kSource = "ETG.1020 6.2; cycle MSD manual 9.1";
  const auto number = [&](std::uint8_t subindex, DataType type, std::string_view entry, double value) {
    rows.push_back(constant(index, subindex, ObjectCode::kRecord, type, entry, value, kSource));
  };
  number(0, DataType::kUnsigned8, name, entries);
  rows.back().record_type = kSyncManagerRecord;
  rows.push_back({.index = index,
                  .subindex = 1,
                  .code = ObjectCode::kRecord,
                  .type = DataType::kUnsigned16,
                  .access = access::kReadWriteConfiguring,
                  .slot = kSyncTypeOutputs,
                  .name = "Synchronisation type",
                  .maximum = 2,
                  .source = kSource});
  number(2, DataType::kUnsigned32, "Cycle time", 125000);
  number(3, DataType::kUnsigned32, "Shift time", 0);
  number(4, DataType::kUnsigned16, "Synchronisation types supported", 0x0007);
  number(5, DataType::kUnsigned32, "Minimum cycle time", 125000);
  number(6, DataType::kUnsigned32, "Calc and copy time", 62500);
}

/// What the drive has seen of the outputs' punctuality since OP (1C32h only).
void add_sync_diagnosis(std::vector<EntryRow>& rows) {
  const auto value = [&](std::uint8_t subindex, DataType type, Value slot, std::string_view name,
                         std::string_view unit) {
    rows.push_back({.index = 0x1C32,
                    .subindex = subindex,
                    .code = ObjectCode::kRecord,
                    .type = type,
                    .slot = slot,
                    .name = name,
                    .unit = unit,
                    .source = "ETG.1020 6.2"});
  };
  value(0x0B, DataType::kUnsigned16, kSyncEventsMissed, "SM event missed", {});
  value(0x11, DataType::kUnsigned32, kSyncDistanceMin, "Minimum SM SYNC distance", "ns");
  value(0x12, DataType::kUnsigned32, kSyncDistanceMax, "Maximum SM SYNC distance", "ns");
  value(kSyncParameterLast, DataType::kBoolean, kSyncError, "Sync error", {});
}

std::vector<EntryRow> make_communication_rows() {
  std::vector<EntryRow> rows(kSingleRows.begin(), kSingleRows.end());
  add_mappings(rows, kPdoLimits.rx_first, "RxPDO mapping");
  add_mappings(rows, kPdoLimits.tx_first, "TxPDO mapping");
  add_assignment(rows, 0x1C12, kPdoLimits.rx_first, "RxPDO assignment");
  add_assignment(rows, 0x1C13, kPdoLimits.tx_first, "TxPDO assignment");
  add_synchronisation(rows, 0x1C32, "Output sync manager parameter", kSyncParameterLast);
  add_sync_diagnosis(rows);
  add_synchronisation(rows, 0x1C33, "Input sync manager parameter", 6);
  return rows;
}

}  // namespace

std::span<const EntryRow> communication_rows() {
  static const std::vector<EntryRow> kRows = make_communication_rows();
  return kRows;
}

}  // namespace driveline::slaves::msd
