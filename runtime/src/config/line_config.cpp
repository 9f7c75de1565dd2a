#include "driveline/runtime/config/line_config.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "config/axis_group_reader.hpp"
#include "config/axis_range_reader.hpp"
#include "config/axis_reader.hpp"
#include "config/bus_reader.hpp"
#include "config/can_bus_reader.hpp"
#include "config/can_slave_reader.hpp"
#include "config/clock_config.hpp"
#include "config/command_reader.hpp"
#include "config/compensation_reader.hpp"
#include "config/coupling_reader.hpp"
#include "config/description_text.hpp"
#include "config/device_files.hpp"
#include "config/eoe_reader.hpp"
#include "config/fault_config.hpp"
#include "config/gantry_reader.hpp"
#include "config/gateway_reader.hpp"
#include "config/process_data_reader.hpp"
#include "config/profile_axis_check.hpp"
#include "config/slave_reader.hpp"
#include "config/stream_reader.hpp"
#include "config/telemetry_reader.hpp"
#include "config/virtual_axis_reader.hpp"
#include "config/wiring_config.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/trajectory/interpolation_method.hpp"
#include "toml/toml_table.hpp"

namespace driveline::runtime {
namespace {

/// Most slaves per master: the cyclic frames of more axes do not fit into a useful cycle.
constexpr std::size_t kMaxSlaves = 256;
/// Most [[...]] tables of one name other than [[slave]]. Names are compared in pairs, which takes seconds for more.
constexpr std::size_t kMaxTables = 10'000;

/// Reads the cables of the simulated line, and its faults.
void read_simulation(TomlReader& root, LineConfig& config) {
  std::vector<std::string> names;
  for (const auto& slave : config.slaves) names.push_back(slave.name);
  config.wiring = read_wiring(root.table("wiring"), names);
  const FaultPlaces places{names, *config.wiring};
  for (auto& reader : root.tables("fault")) config.faults.push_back(read_fault(std::move(reader), places));
}

void read_path(TomlReader reader, const std::filesystem::path& directory, LineConfig& config) {
  PathConfig path;
  path.file = directory / reader.text("file");
  const auto methods = trajectory::interpolation_methods();
  std::vector<std::string_view> names;
  for (const auto& facts : methods) names.push_back(facts.name);
  path.interpolation =
      methods[reader.choice_or("interpolation", static_cast<std::size_t>(path.interpolation), names)].method;
  path.repeat = reader.boolean_or("repeat", false);
  path.relative = reader.boolean_or("relative", false);
  path.compensate_dead_time = reader.choice_or("dead_time", 0, {"none", "compensated"}) == 1;
  constexpr motion::LatePolicy kPolicies[] = {motion::LatePolicy::kStay, motion::LatePolicy::kCatchUp};
  path.late = kPolicies[reader.choice_or("late", 0, {"stay", "catch_up"})];
  reader.finish();
  config.path = path;
}

void read_output(TomlReader reader, LineConfig& config) {
  config.output.directory = reader.text_or("directory", config.output.directory.string());
  config.output.plots = reader.boolean_or("plots", true);
  if (reader.has("capture")) config.output.capture = reader.text("capture");
  reader.finish();
}

void read_recovery(TomlReader reader, RecoveryConfig& recovery) {
  using motion::LossPolicy;
  constexpr LossPolicy kPolicies[] = {LossPolicy::kStop, LossPolicy::kHold, LossPolicy::kContinue};
  constexpr std::int64_t kLongestWait = 86'400;
  recovery.axes = kPolicies[reader.choice_or("axes", 0, {"stop", "hold", "continue"})];
  recovery.give_up = std::chrono::seconds{reader.integer_or("give_up_s", recovery.give_up.count(), 0, kLongestWait)};
  reader.finish();
}

/// Reads TCP/IP to the slaves, and the access of tools to their mailboxes.
void read_services(TomlReader& root, LineConfig& config) {
  if (root.has("eoe")) {
    read_eoe(root.table("eoe"), config);
  } else if (std::any_of(config.slaves.begin(), config.slaves.end(), [](const auto& slave) { return slave.ip; })) {
    root.fail("", "a [[slave]] has an ip, but there is no [eoe] table with its interface");
  }
  if (root.has("gateway")) config.gateway = read_gateway(root.table("gateway"), config.slaves);
}

/// Reads [line] and [bus], by the type of the bus.
void read_line_and_bus(TomlReader& root, DeviceFiles& files, LineConfig& config) {
  if (root.table("bus").choice_or("type", 0, {"ethercat", "can"}) == 1) return read_can_line(root, config);
  read_line(root.table("line"), config);
  read_bus(root.table("bus"), files, config);
}

/// Refuses more tables than a line can have before they are read, which would take seconds.
void check_table_counts(const TomlReader& root, const toml::table& table) {
  for (const auto& [key, node] : table) {
    const auto* tables = node.as_array();
    const auto limit = key.str() == "slave" ? kMaxSlaves : kMaxTables;  // a CAN line has fewer, by its node-IDs
    if (tables == nullptr || tables->size() <= limit) continue;
    root.fail(key.str(), fmt::format("there are {}, the limit is {}", tables->size(), limit));
  }
}

LineConfig read_config(const toml::table& table, const std::filesystem::path& file, const DeviceRegistry& devices,
                       std::optional<motion::cia402::Mode> mode) {
  auto root = read_toml_table(table, file.string());
  check_table_counts(root, table);
  LineConfig config;
  config.devices = devices;
  DeviceFiles files(file.parent_path());
  read_line_and_bus(root, files, config);
  read_realtime(root.table("realtime"), config);
  for (auto& reader : root.tables("slave")) {
    config.slaves.push_back(config.can ? read_can_slave(std::move(reader), config, files)
                                       : read_slave(std::move(reader), config, files));
  }
  if (config.slaves.empty()) root.fail("", "there is no [[slave]]");
  if (config.can) {
    choose_master_node(root, config);
    read_can_faults(root, config);
  } else {
    read_simulation(root, config);
    read_services(root, config);
    if (root.has("dc")) config.clocks = read_clocks(root.table("dc"), config.period, config.slaves);
  }
  for (auto& reader : root.tables("axis"))
    config.axes.push_back(read_axis(std::move(reader), file.parent_path(), config, mode));
  read_virtual_axes(root, config);
  read_process_data(root, config);
  complete_velocity_gains(config);
  check_moduli(root, config);
  for (auto& reader : root.tables("axis_group"))
    config.axis_groups.push_back(read_axis_group(std::move(reader), config));
  if (root.has("path")) read_path(root.table("path"), file.parent_path(), config);
  check_virtual_axes(root, config);
  check_compensations(root, config);
  if (root.has("stream")) config.stream = read_stream(root.table("stream"), config.axes);
  if (config.stream && config.path) {
    root.fail("stream", "needs axes that wait for requests: remove [path], which moves all axes");
  }
  for (auto& reader : root.tables("gantry")) read_gantry(std::move(reader), config);
  check_axis_groups(root, config);
  read_couplings(root, file.parent_path(), config);
  check_profile_axes(root, config);
  config.telemetry = read_telemetry(root.table("telemetry"), file.parent_path(), config.period);
  if (root.has("commands")) config.commands = read_commands(root.table("commands"), config.telemetry);
  read_output(root.table("output"), config);
  read_recovery(root.table("recovery"), config.recovery);
  root.finish();
  for (const auto& note : files.notes()) config.notes.push_back(note);
  return config;
}

}  // namespace

std::string max_lost_text(const LostLimit& limit) {
  if (limit.ms) return fmt::format("the {} ms that [bus] max_lost_ms allows", *limit.ms);
  return fmt::format("the {} cycles that [bus] max_lost_cycles allows", limit.cycles);
}

std::uint32_t exchange_divider(const LineConfig& config, const SlaveConfig& slave) noexcept {
  const auto& groups = config.process_data.groups;
  return slave.group < groups.size() ? groups[slave.group].settings.divider : 1;
}

DeviceIdentity expected_identity(const SlaveConfig& slave) {
  const auto own = slave.esi ? DeviceIdentity{slave.esi->vendor_id, slave.esi->product_code} : slave.device->identity();
  return {slave.vendor_id.value_or(own.vendor_id), slave.product_code.value_or(own.product_code)};
}

const DriveRules& drive_rules(const LineConfig& config, const SlaveConfig& slave) {
  return config.devices.rules_for(expected_identity(slave));
}

Result<LineConfig> parse_line_config(std::string_view text, const std::filesystem::path& name,
                                     const DeviceRegistry& devices, std::optional<motion::cia402::Mode> mode) {
  return read_description(text, name,
                          [&](const toml::table& table) { return read_config(table, name, devices, mode); });
}

Result<LineConfig> load_line_config(const std::filesystem::path& file, const DeviceRegistry& devices,
                                    std::optional<motion::cia402::Mode> mode) {
  const auto text = read_input_file(file);
  if (!text) return tl::unexpected(text.error());
  return parse_line_config(*text, file, devices, mode);
}

}  // namespace driveline::runtime
