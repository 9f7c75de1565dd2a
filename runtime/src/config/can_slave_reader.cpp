#include "config/can_slave_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/can_restrictions.hpp"
#include "config/process_data_reader.hpp"
#include "config/slave_device_reader.hpp"
#include "config/slave_plan_reader.hpp"
#include "config/slave_reader.hpp"

namespace driveline::runtime {
namespace {

using canopen::PdoExchange;
using canopen::PdoPlan;
using std::chrono::milliseconds;

constexpr std::int64_t kLongestTimeMs = 65'535;
constexpr std::uint16_t kFirstRpdo = 0x1600;
constexpr std::uint16_t kFirstTpdo = 0x1A00;
constexpr std::uint16_t kPdos = 512;
/// PDOs of the predefined connection set (CiA 301 7.3.5); others need an identifier.
constexpr std::uint16_t kPredefinedPdos = 4;
constexpr std::size_t kPdoBits = 64;
/// Highest transmission type of synchronous PDOs (CiA 301 Table 71).
constexpr std::uint8_t kLastSynchronous = 240;

std::uint8_t read_node(TomlReader& reader, const LineConfig& config) {
  const auto position = static_cast<std::int64_t>(config.slaves.size()) + 1;
  const auto node = static_cast<std::uint8_t>(reader.integer_or("node", position, 1, 127));
  for (const auto& other : config.slaves) {
    if (other.can.node != node) continue;
    reader.fail("node", fmt::format("is {}, as that of \"{}\": each node-ID is for one slave", node, other.name));
  }
  if (node == config.can->master_node) {
    reader.fail(
        "node",
        fmt::format("is {}, the node-ID of the master: another one is expected here or in [master] node", node));
  }
  return node;
}

std::optional<std::uint32_t> read_number(TomlReader& reader, std::string_view key, std::int64_t least) {
  if (!reader.has(key)) return std::nullopt;
  return static_cast<std::uint32_t>(reader.integer(key, least, 0xFFFFFFFF));
}

/// A device without a heartbeat (1017h) is guarded if it can be (100Ch); with neither of them only its PDOs are
/// watched.
void read_error_control(TomlReader& reader, const SlaveDevice& device, CanSlaveConfig& can) {
  const bool heartbeat = device.has_object(0x1017).value_or(true);
  const auto guard = !heartbeat && device.has_object(0x100C).value_or(false) ? can.heartbeat.count() : 0;
  can.guard_time =
      milliseconds{reader.integer_or("guard_ms", reader.has("heartbeat_ms") ? 0 : guard, 0, kLongestTimeMs)};
  const auto standard = heartbeat && can.guard_time.count() == 0 ? can.heartbeat.count() : 0;
  can.heartbeat = milliseconds{reader.integer_or("heartbeat_ms", standard, 0, kLongestTimeMs)};
  if (can.heartbeat.count() > 0 && can.guard_time.count() > 0) {
    reader.fail("guard_ms", "is set together with heartbeat_ms: a node has one of both (CiA 301 7.2.8.3)");
  }
}

canopen::NodeTimeouts read_node_timeouts(TomlReader reader) {
  constexpr std::int64_t kLongestTimeoutMs = 600'000;
  canopen::NodeTimeouts timeouts;
  const auto read = [&reader](std::string_view key, milliseconds& limit) {
    limit = milliseconds{reader.integer_or(key, limit.count(), 1, kLongestTimeoutMs)};
  };
  read("sdo_ms", timeouts.sdo);
  read("boot_up_ms", timeouts.boot_up);
  read("start_ms", timeouts.start);
  reader.finish();
  return timeouts;
}

void read_times_of_pdo(TomlReader& reader, bool tpdo, PdoPlan& pdo) {
  constexpr double kLongestInhibitUs = 6'553'500.0;
  constexpr double kInhibitUnitUs = 100.0;
  if (reader.has("resend_ms")) {
    if (tpdo) reader.fail("resend_ms", "is for RPDOs, which the master sends; event_ms is expected");
    pdo.resend = milliseconds{reader.integer("resend_ms", 1, kLongestTimeMs)};
  }
  if (reader.has("inhibit_us")) {
    if (!tpdo) reader.fail("inhibit_us", "is for TPDOs, which the node sends");
    const double us = reader.number("inhibit_us", 0.0, kLongestInhibitUs);
    pdo.inhibit_100us = static_cast<std::uint16_t>(std::lround(us / kInhibitUnitUs));
  }
  if (reader.has("event_ms")) {
    if (!tpdo) reader.fail("event_ms", "is for TPDOs, which the node sends; resend_ms is expected");
    pdo.event_ms = static_cast<std::uint16_t>(reader.integer("event_ms", 0, kLongestTimeMs));
  }
}

PdoPlan read_pdo_plan(TomlReader& reader, bool tpdo, std::uint16_t number) {
  PdoPlan pdo;
  pdo.number = number;
  if (reader.has("identifier")) pdo.identifier = static_cast<std::uint16_t>(reader.integer("identifier", 0x181, 0x57F));
  if (pdo.identifier == 0 && number > kPredefinedPdos) {
    reader.fail("index", fmt::format("is that of PDO {}: identifier is expected, the predefined connection set ends at "
                                     "PDO 4",
                                     number));
  }
  pdo.transmission = static_cast<std::uint8_t>(reader.integer_or("transmission", pdo.transmission, 0, 255));
  const bool sync = pdo.transmission <= kLastSynchronous;
  const auto exchange = reader.choice_or("exchange", sync ? 0 : 1, {"sync", "change"});
  pdo.exchange = exchange == 0 ? PdoExchange::kWithSync : PdoExchange::kOnChange;
  read_times_of_pdo(reader, tpdo, pdo);
  for (const auto& entry : reader.texts_or("entries", {})) pdo.objects.push_back(parse_pdo_entry(reader, entry));
  std::size_t bits = 0;
  for (const auto& object : pdo.objects) bits += object.bits;
  if (bits > kPdoBits) reader.fail("entries", fmt::format("are {} bits, a PDO has at most {}", bits, kPdoBits));
  return pdo;
}

void read_can_pdo(TomlReader reader, CanPdoConfig& pdos) {
  for (const auto* key : {"sync_manager", "direction"}) {
    if (reader.has(key)) reader.fail(key, "is for lines of EtherCAT: the index tells the direction of a PDO");
  }
  const auto index = static_cast<std::uint16_t>(reader.integer("index", kFirstRpdo, kFirstTpdo + kPdos - 1));
  const bool tpdo = index >= kFirstTpdo;
  const auto number = static_cast<std::uint16_t>(index - (tpdo ? kFirstTpdo : kFirstRpdo) + 1);
  if (number > kPdos) {
    reader.fail("index", "is no mapping object: 0x1600 to 0x17FF (RPDO) or 0x1A00 to 0x1BFF (TPDO) is expected");
  }
  auto& list = tpdo ? pdos.tpdos : pdos.rpdos;
  if (std::any_of(list.begin(), list.end(), [number](const PdoPlan& other) { return other.number == number; })) {
    reader.fail("index", fmt::format("0x{:04X} is there twice", index));
  }
  list.push_back(read_pdo_plan(reader, tpdo, number));
  reader.finish();
}

motion::StartupSdo read_can_sdo(TomlReader reader) {
  for (const auto* key : {"complete", "before"}) {
    if (reader.has(key)) reader.fail(key, "is for lines of EtherCAT: SDOs are written one by one in Pre-operational");
  }
  return read_startup_sdo(std::move(reader));
}

/// Returns the mappings, for checks of an axis.
motion::PdoConfiguration mappings_of(const CanPdoConfig& pdos) {
  motion::PdoConfiguration mappings;
  const auto add = [](std::uint16_t first, const std::vector<PdoPlan>& plans, std::vector<motion::PdoMapping>& to) {
    for (const auto& plan : plans) {
      to.push_back({static_cast<std::uint16_t>(first + plan.number - 1), plan.objects, std::nullopt, false});
    }
  };
  add(kFirstRpdo, pdos.rpdos, mappings.outputs);
  add(kFirstTpdo, pdos.tpdos, mappings.inputs);
  return mappings;
}

}  // namespace

SlaveConfig read_can_slave(TomlReader reader, const LineConfig& config, DeviceFiles& files) {
  refuse_ethercat_keys(reader, CanTable::kSlave);
  SlaveConfig slave;
  auto& can = slave.can;
  slave.name = read_slave_name(reader, config.slaves);
  can.node = read_node(reader, config);
  if (reader.has("dip")) can.dip = static_cast<std::uint8_t>(reader.integer("dip", 0, 255));
  slave.device = read_can_device(reader, config, files, slave);
  slave.vendor_id = read_number(reader, "vendor_id", 1);
  slave.product_code = read_number(reader, "product_code", 1);
  can.revision = read_number(reader, "revision", 0);
  can.serial_number = read_number(reader, "serial", 0);
  can.optional = reader.boolean_or("optional", false);
  read_error_control(reader, *slave.device, can);
  can.timeouts = read_node_timeouts(reader.table("timeouts"));
  for (auto& sdo : reader.tables("sdo")) slave.plan.sdos.push_back(read_can_sdo(std::move(sdo)));
  for (auto& pdo : reader.tables("pdo")) {
    if (!can.pdos) can.pdos.emplace();
    read_can_pdo(std::move(pdo), *can.pdos);
  }
  if (can.pdos) slave.plan.pdos = mappings_of(*can.pdos);
  slave.names = read_entry_names(reader.table("names"));
  reader.finish();
  return slave;
}

}  // namespace driveline::runtime
