// Rows of the CANopen side: communication profile, PDOs, and the parameters of the field bus.
#include "driveline/slaves/msd/can/can_table.hpp"

#include <algorithm>

#include "driveline/slaves/msd/can/can_values.hpp"
#include "driveline/slaves/msd/core/drive_table.hpp"
#include "msd/core/table_row.hpp"

namespace driveline::slaves::msd {
namespace {

using enum esi::DataType;
using esi::ObjectCode;

constexpr std::string_view kObjects = "MSD manual Table 8.1";
constexpr std::string_view kCobIds = "MSD manual 8.1.1: predefined connection set";
constexpr std::string_view kHeartbeat = "MSD manual 8.4.2";
constexpr std::uint16_t kCommunicationRecord = 0x0020;
constexpr std::uint16_t kMappingRecord = 0x0021;
constexpr std::uint8_t kMappedObjects = 8;
constexpr double kSyncCobId = 0x80;
constexpr double kEventDriven = 255;
constexpr double kEveryBit = 0xFFFFFFFF;

constexpr std::array kCommunicationRows = {
    variable(0x1005, kUnsigned32, kStored, "COB-ID SYNC", {kSyncCobId}, {}, kObjects),
    variable(0x1006, kStored, kCanValue.communication_cycle, "Communication cycle period", {1000}, "us",
             "MSD manual 6.4.2, Table 8.1; default that of P 306 and 60C2h"),
    variable(0x1007, kUnsigned32, kStored, "Synchronous window length", {}, "us", kObjects),
    variable(0x100C, kUnsigned16, kStored, "Guard time", {}, "ms", kObjects),
    variable(0x100D, kUnsigned8, kStored, "Life time factor", {}, {}, kObjects),
    variable(0x1014, kUnsigned32, kStored, "COB-ID EMCY", {kSyncCobId}, {}, "MSD manual Table 8.1; access CiA 301"),
    variable(0x1017, kUnsigned16, kStored, "Producer heartbeat time", {}, "ms", kHeartbeat),
    variable(p(2005), kStored, kCanValue.address, "COM_CAN_Adr", {0, kNoMinimum, 127}, {},
             "MSD manual 4.4; range ours"),
    variable(p(2006), kStored, kCanValue.bit_rate, "COM_CAN_Baudrate", {1000, 20, 1000}, "kbit/s",
             "MSD manual 4.6.3, Table 6.4"),
    variable(p(2015), kStored, kCanValue.communication_cycle, "COM_301_CycleTime", {1000}, "us",
             "MSD manual 6.4.2: alias of 1006h; name ours"),
    variable(p(2058), access::kRead, kCanValue.active_address, "COM_CAN_Adr_Act", {}, {}, "MSD manual 4.4.2"),
    variable(p(2059), access::kRead, kCanValue.active_bit_rate, "COM_CAN_Baudrate_Act", {}, "kbit/s",
             "MSD manual 6.5.1"),
    variable(p(2061), kStored, kCanValue.telegram, "COM_CAN_Timeout_Type", {0, kNoMinimum, 1}, {},
             "MSD manual Table 8.6"),
    variable(p(2062), kStored, kCanValue.telegram_time_out, "COM_CAN_Timeout_Value", {}, "ms", "MSD manual Table 8.6"),
};

constexpr std::array kConsumerRows = {
    array_length(0x1016, "Consumer heartbeat time", 1, kHeartbeat),
    [] {
      EntryRow row = variable(0x1016, kUnsigned32, kStored, "Consumer heartbeat time", {}, {},
                              "MSD manual 8.4.2: one producer; bits CiA 301");
      row.subindex = 1;
      row.code = ObjectCode::kArray;
      return row;
    }(),
};

/// Adds P 2007 (MSD manual Table 8.4).
void add_event_masks(std::vector<EntryRow>& rows) {
  constexpr std::array<std::string_view, 8> kNames{"EvMsk_TxPdo1L", "EvMsk_TxPdo1H", "EvMsk_TxPdo2L", "EvMsk_TxPdo2H",
                                                   "EvMsk_TxPdo3L", "EvMsk_TxPdo3H", "EvMsk_TxPdo4L", "EvMsk_TxPdo4H"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const std::string_view name = i == 0 ? "COM_301_EvMask" : kNames[i];
    rows.push_back(element(p(2007), static_cast<std::uint8_t>(i), kStored, kCanValue.event_masks[i], name, {kEveryBit},
                           {}, "MSD manual Table 8.4"));
  }
}

EntryRow record_entry(std::uint16_t index, std::uint8_t subindex, esi::DataType type, std::string_view name,
                      double initial, std::string_view unit, std::string_view source) {
  EntryRow row = variable(index, type, kStored, name, {initial}, unit, source);
  row.subindex = subindex;
  row.code = ObjectCode::kRecord;
  return row;
}

/// Adds the communication parameters of a PDO; TxPDOs have inhibit time and event timer, too.
void add_communication(std::vector<EntryRow>& rows, std::uint16_t index, double cob_id, bool tx) {
  constexpr std::string_view kTypes = "MSD manual 8.3.1; default CiA 301";
  const std::string_view name = tx ? "TxPDO communication parameter" : "RxPDO communication parameter";
  rows.push_back(record_length(index, kCommunicationRecord, name, tx ? 5 : 2, kObjects));
  rows.push_back(record_entry(index, 1, kUnsigned32, "COB-ID", cob_id, {}, kCobIds));
  rows.push_back(record_entry(index, 2, kUnsigned8, "Transmission type", kEventDriven, {}, kTypes));
  if (!tx) return;
  rows.push_back(record_entry(index, 3, kUnsigned16, "Inhibit time", 0, "100 us", "MSD manual 8.3.1"));
  rows.push_back(record_entry(index, 5, kUnsigned16, "Event timer", 0, "ms", "MSD manual 8.3.1"));
}

/// Adds the mapping of a PDO: empty by default, stored with the parameters (MSD manual 8.3.3).
void add_mapping(std::vector<EntryRow>& rows, std::uint16_t index, std::string_view name) {
  constexpr std::string_view kMapping = "MSD manual 8.3.3, Table 8.5";
  rows.push_back(record_entry(index, 0, kUnsigned8, name, 0, {}, kMapping));
  rows.back().record_type = kMappingRecord;
  for (std::uint8_t sub = 1; sub <= kMappedObjects; ++sub) {
    rows.push_back(record_entry(index, sub, kUnsigned32, "Mapped object", 0, {}, kMapping));
  }
}

std::vector<EntryRow> rows_on_can(Variant variant) {
  constexpr double kOnCan = 0x67;  // modes 1, 2, 3, 6, 7
  auto rows = drive_rows(variant);
  const auto modes = std::find_if(rows.begin(), rows.end(), [](const EntryRow& row) { return row.index == 0x6502; });
  modes->initial = kOnCan;
  modes->source = "MSD manual 12.1: modes 8, 9, 10 on EtherCAT only; bits CiA 402";
  return rows;
}

template <Variant kVariant>
const DictionaryTable& can_table_of() {
  static const DictionaryTable kTable({rows_on_can(kVariant), can_rows(kVariant)}, kCanValue.end());
  return kTable;
}

}  // namespace

std::vector<EntryRow> can_rows(Variant variant) {
  std::vector<EntryRow> rows(kCommunicationRows.begin(), kCommunicationRows.end());
  // The ServoOne has no heartbeat consumer (ServoOne manual 8.4).
  if (variant == Variant::kMsd) rows.insert(rows.end(), kConsumerRows.begin(), kConsumerRows.end());
  add_event_masks(rows);
  for (std::uint16_t i = 0; i < kCanPdos; ++i) {
    const auto at = [i](unsigned first) { return static_cast<std::uint16_t>(first + i); };
    add_communication(rows, at(0x1400), 0x200 + 0x100 * i, false);
    add_mapping(rows, at(0x1600), "RxPDO mapping");
    add_communication(rows, at(0x1800), 0x180 + 0x100 * i, true);
    add_mapping(rows, at(0x1A00), "TxPDO mapping");
  }
  return rows;
}

const DictionaryTable& can_dictionary_table(Variant variant) {
  switch (variant) {
    case Variant::kServoOne:
      return can_table_of<Variant::kServoOne>();
    case Variant::kServoOneJunior:
      return can_table_of<Variant::kServoOneJunior>();
    case Variant::kMsd:
      break;
  }
  return can_table_of<Variant::kMsd>();
}

}  // namespace driveline::slaves::msd
