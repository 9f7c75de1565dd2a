// Rows of the EtherCAT side: sync managers, PDO mapping and assignment, synchronisation.
#include <vector>

#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/ethercat_values.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/slaves/sync_demand.hpp"
#include "msd/core/table_row.hpp"

namespace driveline::slaves::msd {
namespace {

using enum esi::DataType;
using esi::ObjectCode;

constexpr std::string_view kErrorSettings = "ETG.1020 10F1h; without local error reaction";
constexpr std::string_view kEtg = "ETG.1000.6 5.6.7";
constexpr std::string_view kSynchronisation = "ETG.1020 6.2; cycle MSD manual 9.1";
constexpr std::string_view kEtgSync = "ETG.1020 6.2";
constexpr std::string_view kShiftTooShort = "ETG.1020 6.2; what counts is ours: less than sub-index 06";
constexpr std::uint16_t kPdoMappingRecord = 0x0021;
constexpr std::uint16_t kSyncManagerRecord = 0x0029;
constexpr std::uint8_t kSyncParameterLast = 0x20;
constexpr auto kProcessDataPeriodNs = static_cast<double>(kProcessDataPeriod.count());

constexpr std::array kSingleRows = {
    constant(0x10F1, 0, ObjectCode::kRecord, kUnsigned8, "Error settings", 2, kErrorSettings),
    field(0x10F1, 2, access::kReadWriteConfiguring | access::kBackup, kBusValue.sync_error_limit,
          "Sync error counter limit", {30}, {},
          "ETG.1020 10F1h: a cycle without outputs counts 3, one with them -1; initial value ours"),
    array_length(0x1C00, "Sync manager communication type", 4, kEtg),
    constant(0x1C00, 1, ObjectCode::kArray, kUnsigned8, "Sync manager 0: mailbox out", 1, kEtg),
    constant(0x1C00, 2, ObjectCode::kArray, kUnsigned8, "Sync manager 1: mailbox in", 2, kEtg),
    constant(0x1C00, 3, ObjectCode::kArray, kUnsigned8, "Sync manager 2: outputs", 3, kEtg),
    constant(0x1C00, 4, ObjectCode::kArray, kUnsigned8, "Sync manager 3: inputs", 4, kEtg),
};

/// Adds 1600h-1603h or 1A00h-1A03h: empty by default, stored with the parameters (MSD manual 8.3.3).
void add_mappings(std::vector<EntryRow>& rows, std::uint16_t first, std::string_view name) {
  const EntryRow base{.code = ObjectCode::kRecord,
                      .access = access::kReadWriteConfiguring | access::kBackup,
                      .source = "MSD manual 8.3.3, Table 8.5"};
  for (std::uint8_t pdo = 0; pdo < kPdoLimits.pdos; ++pdo) {
    EntryRow row = base;
    row.index = static_cast<std::uint16_t>(first + pdo);
    row.type = kUnsigned8;
    row.name = name;
    row.record_type = kPdoMappingRecord;
    rows.push_back(row);
    row.type = kUnsigned32;
    row.name = "Mapped object";
    row.record_type = 0;
    for (row.subindex = 1; row.subindex <= kPdoLimits.objects; ++row.subindex) rows.push_back(row);
  }
}

/// Adds 1C12h, 1C13h: all PDOs are assigned, in order.
void add_assignment(std::vector<EntryRow>& rows, std::uint16_t index, std::uint16_t first, std::string_view name) {
  EntryRow row{.index = index,
               .code = ObjectCode::kArray,
               .type = kUnsigned8,
               .access = access::kReadWriteConfiguring | access::kBackup,
               .name = name,
               .initial = static_cast<double>(kPdoLimits.pdos),
               .source = kEtg};
  rows.push_back(row);
  row.type = kUnsigned16;
  row.name = "Assigned PDO";
  for (std::uint8_t pdo = 0; pdo < kPdoLimits.pdos; ++pdo) {
    row.subindex = static_cast<std::uint8_t>(pdo + 1);
    row.initial = first + pdo;
    rows.push_back(row);
  }
}

/// Adds the first entries of 1C32h, 1C33h (ETG.1020 Table 80): free run, SM event or DC SYNC0, cycle from 125 us (MSD
/// manual 9.1).
void add_synchronisation(std::vector<EntryRow>& rows, std::uint16_t index, std::string_view name,
                         Slot<std::uint16_t> type_slot, SyncType last_type) {
  const auto number = [&](std::uint8_t subindex, esi::DataType type, std::string_view entry, double value) {
    rows.push_back(constant(index, subindex, ObjectCode::kRecord, type, entry, value, kSynchronisation));
  };
  rows.push_back(record_length(index, kSyncManagerRecord, name, kSyncParameterLast, kSynchronisation));
  rows.push_back(field(index, 1, access::kReadWriteConfiguring, type_slot, "Synchronisation type",
                       {0, kNoMinimum, static_cast<double>(last_type)}, {}, kSynchronisation));
  rows.push_back(field(index, 2, access::kRead, kBusValue.sync_cycle, "Cycle time", {kProcessDataPeriodNs}, "ns",
                       "ETG.1020 6.2: SYNC0 cycle; else the process data cycle of the drive"));
  number(3, kUnsigned32, "Shift time", 0);
  number(4, kUnsigned16, "Synchronisation types supported", 0x0007);
  number(5, kUnsigned32, "Minimum cycle time", 125000);
  number(6, kUnsigned32, "Calc and copy time", static_cast<double>(kCalcAndCopyTime.count()));
}

/// Adds the counters of 1C32h and 1C33h, which count since OP. Outputs and inputs have the same ones, because one event
/// exchanges both.
void add_counters(std::vector<EntryRow>& rows, std::uint16_t index) {
  rows.push_back(field(index, 0x0B, access::kRead, kBusValue.sync_events_missed, "SM event missed", {}, {}, kEtgSync));
  rows.push_back(field(index, 0x0C, access::kRead, kBusValue.sync_cycles_exceeded, "Cycle exceeded", {}, {}, kEtgSync));
  rows.push_back(
      field(index, 0x0D, access::kRead, kBusValue.sync_shifts_too_short, "Shift too short", {}, {}, kShiftTooShort));
}

/// Adds the time from complete outputs to SYNC0, measured since OP.
void add_distances(std::vector<EntryRow>& rows, std::uint16_t index) {
  rows.push_back(
      field(index, 0x11, access::kRead, kBusValue.sync_distance_min, "Minimum SM SYNC distance", {}, "ns", kEtgSync));
  rows.push_back(
      field(index, 0x12, access::kRead, kBusValue.sync_distance_max, "Maximum SM SYNC distance", {}, "ns", kEtgSync));
}

void add_sync_error(std::vector<EntryRow>& rows, std::uint16_t index) {
  rows.push_back(field(index, kSyncParameterLast, access::kRead, kBusValue.sync_error, "Sync error", {}, {}, kEtgSync));
}

std::vector<EntryRow> make_ethercat_rows() {
  std::vector<EntryRow> rows(kSingleRows.begin(), kSingleRows.end());
  add_mappings(rows, kPdoLimits.rx_first, "RxPDO mapping");
  add_mappings(rows, kPdoLimits.tx_first, "TxPDO mapping");
  add_assignment(rows, 0x1C12, kPdoLimits.rx_first, "RxPDO assignment");
  add_assignment(rows, 0x1C13, kPdoLimits.tx_first, "TxPDO assignment");
  add_synchronisation(rows, 0x1C32, "Output sync manager parameter", kBusValue.sync_type_outputs, SyncType::kSync0);
  add_counters(rows, 0x1C32);
  add_distances(rows, 0x1C32);
  add_sync_error(rows, 0x1C32);
  add_synchronisation(rows, 0x1C33, "Input sync manager parameter", kBusValue.sync_type_inputs, SyncType::kSm2Event);
  add_counters(rows, 0x1C33);
  add_sync_error(rows, 0x1C33);
  return rows;
}

}  // namespace

std::span<const EntryRow> ethercat_rows() {
  static const std::vector<EntryRow> kRows = make_ethercat_rows();
  return kRows;
}

}  // namespace driveline::slaves::msd
