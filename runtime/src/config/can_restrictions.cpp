#include "config/can_restrictions.hpp"

#include <fmt/format.h>

#include <array>

namespace driveline::runtime {
namespace {

/// A key of EtherCAT, and what a CAN line has instead.
struct Restriction {
  CanTable table;
  std::string_view key;
  std::string_view why;
};

constexpr std::array kRestrictions{
    Restriction{CanTable::kRoot, "dc", "a CAN bus has no distributed clocks; SYNC is the clock of its nodes"},
    Restriction{CanTable::kRoot, "wiring", "a CAN bus is one cable: [bus] length_m and terminators are expected"},
    Restriction{CanTable::kRoot, "eoe", "CANopen has no Ethernet over the bus"},
    Restriction{CanTable::kRoot, "gateway", "CANopen has no mailboxes"},
    Restriction{CanTable::kRoot, "group",
                "PDOs of all nodes follow SYNC; [[slave.pdo]] exchange and transmission are "
                "expected"},
    Restriction{CanTable::kRoot, "process_data", "PDOs on a CAN bus have identifiers and no layout in a frame"},
    Restriction{CanTable::kBus, "interface2", "a CAN bus is no ring"},
    Restriction{CanTable::kBus, "esi", "nodes have an EDS: model = \"eds\" in a [[slave]] is expected"},
    Restriction{CanTable::kBus, "port", "interface names the protocol of a CAN port, as slcan:tcp:HOST:PORT"},
    Restriction{CanTable::kBus, "launch_ahead_us", "no CAN port sends at a time that is given"},
    Restriction{CanTable::kBus, "acyclic_bytes", "what SYNC and PDOs leave free of the bus is for SDO"},
    Restriction{CanTable::kSlave, "alias", "a node is found by its node-ID: node is expected"},
    Restriction{CanTable::kSlave, "device_id", "a node is found by its node-ID: node is expected"},
    Restriction{CanTable::kSlave, "hot_connect", "a node that may be missing has optional = true"},
    Restriction{CanTable::kSlave, "lrw", "it chooses datagrams"},
    Restriction{CanTable::kSlave, "eeprom_to_application", "nodes have no EEPROM that the master reads"},
    Restriction{CanTable::kSlave, "sii", "nodes have no EEPROM that the master reads"},
    Restriction{CanTable::kSlave, "sii_file", "nodes have no EEPROM that the master reads"},
    Restriction{CanTable::kSlave, "esi", "a node has an EDS: model = \"eds\" is expected"},
    Restriction{CanTable::kSlave, "watchdog", "nodes notice the loss of the master by its heartbeat or guarding"},
    Restriction{CanTable::kSlave, "startup", "it chooses writes that EtherCAT has; [[slave.sdo]] optional is expected"},
    Restriction{CanTable::kSlave, "dc", "a CAN bus has no distributed clocks; SYNC is the clock of its nodes"},
    Restriction{CanTable::kSlave, "ip", "CANopen has no Ethernet over the bus"},
    Restriction{CanTable::kSlave, "persona", "it is the quirk of a slave controller"},
    Restriction{CanTable::kSlave, "processing_ns", "frames do not pass through nodes"},
    Restriction{CanTable::kSlave, "forwarding_ns", "frames do not pass through nodes"},
};

}  // namespace

void refuse_ethercat_keys(TomlReader& reader, CanTable table) {
  for (const auto& each : kRestrictions) {
    if (each.table != table || !reader.has(each.key)) continue;
    reader.fail(each.key, fmt::format("is for lines of EtherCAT: {}", each.why));
  }
}

std::string why_not_on_can(motion::cia402::Mode mode) {
  return fmt::format("mode {} is EtherCAT only (MSD manual 2077-2079); use interpolated position",
                     static_cast<int>(mode));
}

}  // namespace driveline::runtime
