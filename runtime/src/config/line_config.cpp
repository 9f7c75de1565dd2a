#include "driveline/runtime/config/line_config.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/axis_group_reader.hpp"
#include "config/axis_range_reader.hpp"
#include "config/clock_config.hpp"
#include "config/command_reader.hpp"
#include "config/compensation_reader.hpp"
#include "config/coupling_reader.hpp"
#include "config/device_files.hpp"
#include "config/eoe_reader.hpp"
#include "config/fault_config.hpp"
#include "config/gantry_reader.hpp"
#include "config/gateway_reader.hpp"
#include "config/process_data_reader.hpp"
#include "config/slave_device_reader.hpp"
#include "config/slave_plan_reader.hpp"
#include "config/stream_reader.hpp"
#include "config/telemetry_reader.hpp"
#include "config/virtual_axis_reader.hpp"
#include "config/wiring_config.hpp"
#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/motion/drive/axis_objects.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/runtime/config/persona_text.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/slaves/esc/sii_file.hpp"
#include "driveline/slaves/persona/persona_slave.hpp"
#include "driveline/trajectory/axis_name.hpp"
#include "driveline/trajectory/interpolation_method.hpp"
#include "toml/duration.hpp"
#include "toml/toml_depth.hpp"
#include "toml/toml_table.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

/// Most slaves per master: the cyclic frames of more axes do not fit into a useful cycle.
constexpr std::size_t kMaxSlaves = 256;
/// Most [[...]] tables of one name other than [[slave]]. Names are compared in pairs, which takes seconds for more.
constexpr std::size_t kMaxTables = 10'000;
/// Longest text of a description: 256 slaves with 32 KiB each.
constexpr std::size_t kMaxDescriptionBytes = std::size_t{8} << 20;
/// Longest name in the telemetry records.
constexpr std::size_t kMaxName = 31;
/// Longest delay of a slave; a longer one would use up the cycle.
constexpr std::int64_t kMaxDelayNs = 1'000'000;
constexpr std::string_view kNameLength = "must have 1 to 31 characters";

void read_line(TomlReader reader, LineConfig& config) {
  config.name = reader.text_or("name", config.name);
  if (config.name.empty() || config.name.size() > kMaxName) reader.fail("name", kNameLength);
  config.period = from_us(reader.number_or("cycle_us", 125.0, 125.0, 100000.0));
  // MSD manual 9.1: the cycle time is a multiple of 125 us.
  if (config.period.count() % 125000 != 0)
    reader.fail("cycle_us", "must be a multiple of 125, the drives' process data cycle");
  reader.finish();
}

/// Reads how long axes may be without process data: in cycles or as a time.
void read_max_lost(TomlReader& reader, LineConfig& config) {
  constexpr std::int64_t kMaxCycles = 10'000;
  const bool in_cycles = reader.has("max_lost_cycles");
  if (!reader.has("max_lost_ms")) {
    config.max_lost_cycles =
        static_cast<std::uint32_t>(reader.integer_or("max_lost_cycles", config.max_lost_cycles, 1, kMaxCycles));
    return;
  }
  if (in_cycles)
    reader.fail("max_lost_ms", "is set together with max_lost_cycles: both are the same limit, only one is expected");
  const double cycle_ms = std::chrono::duration<double, std::milli>(config.period).count();
  config.max_lost_ms = reader.number("max_lost_ms", cycle_ms, static_cast<double>(kMaxCycles) * cycle_ms);
  // Rounded down to whole cycles, so that it is never longer than the file says.
  config.max_lost_cycles = static_cast<std::uint32_t>(std::llround(*config.max_lost_ms * 1e6) / config.period.count());
}

/// Reads the time by which frames are handed to the kernel before they leave.
void read_launch_ahead(TomlReader& reader, LineConfig& config) {
  if (!reader.has("launch_ahead_us")) return;
  const double longest = static_cast<double>(rt::CycleTimer::max_wake_ahead(config.period).count()) / 1000.0;
  config.launch_ahead = from_us(reader.number("launch_ahead_us", 1.0, longest));
  if (config.port == port::PortChoice::kXdp)
    reader.fail("launch_ahead_us", "needs a packet socket: set port = \"raw\" or \"auto\"");
  if (config.interface2)
    reader.fail("launch_ahead_us", "cannot be used with interface2: both ends of a ring send at the same time");
}

void read_bus(TomlReader reader, DeviceFiles& files, LineConfig& config) {
  if (reader.has("esi")) config.esi_library = files.read_library(reader, "esi");
  if (reader.has("interface")) config.interface = reader.text("interface");
  if (reader.has("interface2")) config.interface2 = reader.text("interface2");
  if (config.interface2 && !config.interface) reader.fail("interface2", "needs interface, the other end of the ring");
  if (config.interface2 && *config.interface2 == *config.interface) {
    reader.fail("interface2",
                fmt::format("is \"{}\", the same as interface: a ring needs two interfaces", *config.interface2));
  }
  const auto port = reader.choice_or("port", 0, {"auto", "raw", "xdp"});
  config.port = std::array{port::PortChoice::kAuto, port::PortChoice::kRaw, port::PortChoice::kXdp}.at(port);
  read_launch_ahead(reader, config);
  read_max_lost(reader, config);
  if (reader.has("acyclic_bytes")) {
    config.acyclic_bytes =
        static_cast<std::size_t>(reader.integer("acyclic_bytes", 60, ecat_master::AcyclicChannel::kMaxBytes));
  }
  reader.finish();
}

void read_realtime(TomlReader reader, LineConfig& config) {
  auto& realtime = config.realtime;
  if (reader.has("policy")) {
    const bool enforce = reader.choice_or("policy", 0, {"enforce", "degrade"}) == 0;
    config.policy = enforce ? rt::RealtimePolicy::kEnforce : rt::RealtimePolicy::kDegrade;
  }
  realtime.priority = static_cast<int>(reader.integer_or("priority", 80, 1, 99));
  if (reader.has("cpu")) realtime.cpu = static_cast<int>(reader.integer("cpu", 0, 1023));
  if (reader.has("simulation_cpu")) config.simulation_cpu = static_cast<int>(reader.integer("simulation_cpu", 0, 1023));
  realtime.lock_memory = reader.boolean_or("lock_memory", true);
  constexpr std::int64_t kLongestLatencyUs = 1'000'000;
  const auto latency_us = reader.integer_or("cpu_latency_us", 0, -1, kLongestLatencyUs);
  realtime.cpu_latency = latency_us < 0 ? std::nullopt : std::optional(std::chrono::microseconds{latency_us});
  using Receive = ecat_master::ReceiveStrategy;
  const auto receive = reader.choice_or("receive", 0, {"spin", "sleep", "block"});
  config.receive = std::array{Receive::kSpin, Receive::kSleep, Receive::kBlock}.at(receive);
  const double longest = static_cast<double>(rt::CycleTimer::max_wake_ahead(config.period).count()) / 1000.0;
  if (reader.is_text("wake_ahead_us")) {
    const auto word = reader.text("wake_ahead_us");
    if (word != "auto")
      reader.fail("wake_ahead_us", fmt::format("is \"{}\", \"auto\" or 0 to {:g} is expected", word, longest));
  } else if (reader.has("wake_ahead_us")) {
    config.wake_ahead = from_us(reader.number("wake_ahead_us", 0.0, longest));
  }
  reader.finish();
}

/// Returns the names of `axes`, in their order.
std::vector<std::string_view> names_of(const std::vector<motion::AxisConfig>& axes) {
  std::vector<std::string_view> names;
  for (const auto& axis : axes) names.push_back(axis.name);
  return names;
}

/// Reads the name of an axis, which must be valid as the name of a path column, too.
std::string read_axis_name(TomlReader& reader, const std::vector<motion::AxisConfig>& others) {
  auto name = reader.text("name");
  if (const auto checked = trajectory::check_axis_name(name, names_of(others)); !checked) {
    reader.fail("name", describe(checked.error()));
  }
  return name;
}

/// Reads a name that is not used in `others`.
template <typename Named>
std::string read_name(TomlReader& reader, const std::vector<Named>& others) {
  auto name = reader.text("name");
  if (name.empty() || name.size() > kMaxName) reader.fail("name", kNameLength);
  if (std::any_of(others.begin(), others.end(), [&](const Named& other) { return other.name == name; })) {
    reader.fail("name", fmt::format("\"{}\" is there twice", name));
  }
  return name;
}

/// Reads the EEPROM content that an earlier simulation has stored.
void read_eeprom(TomlReader& reader, const std::filesystem::path& directory, SlaveConfig& slave) {
  if (!reader.has("sii_file")) return;
  slave.sii_file = directory / reader.text("sii_file");
  auto content = slaves::SiiFile(slave.sii_file).load();
  if (!content) reader.fail("sii_file", describe(content.error()));
  slave.sii_content = std::move(*content);
}

/// Reads the quirks of the simulated device. A stored EEPROM replaces the content that an EEPROM persona would change.
std::vector<slaves::Persona> read_personas(TomlReader& reader) {
  if (!reader.has("persona")) return {};
  const auto words = reader.is_text("persona") ? std::vector{reader.text("persona")} : reader.texts_or("persona", {});
  std::vector<slaves::Persona> personas;
  for (const auto& word : words) {
    const auto persona = parse_persona(word);
    if (!persona) reader.fail("persona", persona.error().reason);
    const auto name = slaves::persona_row(persona->kind).name;
    if (slaves::has_persona(personas, persona->kind))
      reader.fail("persona", fmt::format("\"{}\" is there twice", name));
    if (slaves::changes_eeprom(persona->kind) && reader.has("sii_file")) {
      reader.fail("persona", fmt::format("\"{}\" changes the EEPROM, whose content comes from sii_file", name));
    }
    personas.push_back(*persona);
  }
  return personas;
}

/// Finds the head of the hot-connect group of a slave. Members of a group follow each other in the file as on the line.
ecat_master::HotConnectPlace find_hot_connect_place(const TomlReader& reader, const std::string& head,
                                                    const std::vector<SlaveConfig>& others) {
  const auto found = std::find_if(others.begin(), others.end(), [&](const auto& other) { return other.name == head; });
  if (found == others.end()) {
    reader.fail("hot_connect",
                fmt::format("is \"{}\": true, false, or the name of a [[slave]] above is expected", head));
  }
  if (!found->plan.hot_connect || found->plan.behind) {
    reader.fail("hot_connect",
                fmt::format("is \"{0}\", which is not the head of a group: hot_connect = true and alias or "
                            "device_id of \"{0}\" are expected",
                            head));
  }
  const ecat_master::HotConnectPlace place{static_cast<std::size_t>(found - others.begin()),
                                           static_cast<std::size_t>(others.end() - found)};
  for (auto between = found + 1; between != others.end(); ++between) {
    if (!between->plan.behind || between->plan.behind->head != place.head) {
      reader.fail("hot_connect", fmt::format("is \"{}\", but \"{}\" is between them and not in that group: the "
                                             "slaves of a group must be adjacent",
                                             head, between->name));
    }
  }
  return place;
}

SlaveConfig read_slave(TomlReader reader, const LineConfig& config, DeviceFiles& files) {
  const auto& others = config.slaves;
  SlaveConfig slave;
  slave.name = read_name(reader, others);
  read_slave_device(reader, config, files, slave);
  auto identity = [&reader](std::string_view key) -> std::optional<std::uint32_t> {
    if (!reader.has(key)) return std::nullopt;
    return static_cast<std::uint32_t>(reader.integer(key, 1, 0xFFFFFFFF));
  };
  slave.vendor_id = identity("vendor_id");
  slave.product_code = identity("product_code");
  slave.plan = read_slave_plan(reader);
  if (!slave.plan.hot_head.empty()) slave.plan.behind = find_hot_connect_place(reader, slave.plan.hot_head, others);
  if (slave.esi && slave.plan.pdos) {
    ecat_master::complete_pdos(*slave.esi, *slave.plan.pdos);
    if (const auto fit = ecat_master::check_pdos(*slave.esi, *slave.plan.pdos); !fit)
      reader.fail("pdo", describe(fit.error()));
  }
  slave.names = read_entry_names(reader.table("names"));
  slave.dc = read_slave_clock(reader.table("dc"));
  slave.ip = read_slave_ip(reader, others);
  slave.personas = read_personas(reader);
  read_eeprom(reader, files.directory(), slave);
  slave.delays.processing =
      nanoseconds{reader.integer_or("processing_ns", slave.delays.processing.count(), 0, kMaxDelayNs)};
  slave.delays.forwarding =
      nanoseconds{reader.integer_or("forwarding_ns", slave.delays.forwarding.count(), 0, kMaxDelayNs)};
  reader.finish();
  return slave;
}

/// Reads the cables of the simulated line, and its faults.
void read_simulation(TomlReader& root, LineConfig& config) {
  std::vector<std::string> names;
  for (const auto& slave : config.slaves) names.push_back(slave.name);
  config.wiring = read_wiring(root.table("wiring"), names);
  const FaultPlaces places{names, *config.wiring};
  for (auto& reader : root.tables("fault")) config.faults.push_back(read_fault(std::move(reader), places));
}

/// In CST the axis moves only by torque from velocity errors: without a gain it would never move.
void read_velocity_gain(TomlReader& reader, motion::AxisConfig& axis) {
  const bool needed = axis.mode == motion::cia402::Mode::kCyclicTorque;
  const bool given = reader.has("velocity_gain");
  if (given) axis.velocity_gain = reader.number("velocity_gain", 0.0, 1e6);
  if (!needed || axis.velocity_gain > 0.0) return;
  if (given) reader.fail("velocity_gain", "is 0: with mode \"cst\" the axis would never move");
  if (axis.inertia > 0.0) return;
  reader.fail("velocity_gain",
              "mode \"cst\" needs it, or inertia to calculate it: without either the axis would never move");
}

/// Sets the default gain of the velocity loop over the bus: 100/s times the inertia, less if exchanges are rare.
void complete_velocity_gains(LineConfig& config) {
  constexpr double kBandwidthPerS = 100.0;
  constexpr double kPerExchange = 0.2;
  for (auto& axis : config.axes) {
    if (axis.velocity_gain > 0.0 || axis.is_virtual()) continue;
    const std::chrono::duration<double> exchange = config.period * exchange_divider(config, config.slaves[axis.slave]);
    axis.velocity_gain = axis.inertia * std::min(kBandwidthPerS, kPerExchange / exchange.count());
  }
}

/// Checks only PDOs with entries: the entries of others are known only once the slave has been found.
void check_objects(const TomlReader& reader, const SlaveConfig& slave, const motion::AxisConfig& axis) {
  if (!slave.plan.pdos) return;
  for (const auto* direction : {&slave.plan.pdos->outputs, &slave.plan.pdos->inputs}) {
    if (std::any_of(direction->begin(), direction->end(), [](const auto& pdo) { return pdo.objects.empty(); })) return;
  }
  const auto missing =
      motion::missing_objects(axis.mode, motion::pdos_of_drive(*slave.plan.pdos, axis.drive), axis.feed_forward.any());
  if (missing.empty()) return;
  reader.fail("slave", fmt::format("the [[slave.pdo]] of \"{}\" are not enough: {}", slave.name,
                                   motion::describe_missing(axis.mode, missing, *slave.plan.pdos, axis.drive)));
}

/// Returns the unit of the axis; null: the file gives none.
const trajectory::PositionUnit* read_unit(TomlReader& reader, trajectory::AxisKind kind) {
  if (!reader.has("unit")) return nullptr;
  const auto name = reader.text("unit");
  const auto* unit = trajectory::find_position_unit(name);
  if (unit == nullptr || unit->kind != kind) {
    reader.fail("unit", fmt::format("is \"{}\", {} is expected", name,
                                    kind == trajectory::AxisKind::kLinear
                                        ? "\"m\", \"mm\" or \"um\" of an axis with feed_mm_per_revolution"
                                        : "\"rad\", \"deg\" or \"rev\" of an axis without feed_mm_per_revolution"));
  }
  return unit;
}

/// Reads a position, velocity or acceleration in the unit of the axis, or in rad or m if it has none. The limits are in
/// rad or m. Without the key the value stays unchanged.
void read_in_unit(TomlReader& reader, std::string_view key, const motion::AxisConfig& axis, double minimum,
                  double maximum, double& value) {
  if (!reader.has(key)) return;
  const auto& unit = motion::position_unit(axis);
  value = unit.to_si(reader.number(key, unit.from_si(minimum), unit.from_si(maximum)));
}

void read_following_error(TomlReader& reader, motion::AxisConfig& axis) {
  constexpr std::int64_t kLongestMs = 60'000;
  if (!reader.has("following_error_window")) {
    if (reader.has("following_error_timeout_ms"))
      reader.fail("following_error_timeout_ms", "has no effect without following_error_window");
    return;
  }
  read_in_unit(reader, "following_error_window", axis, 1e-9, 1e6, axis.following_error_window.emplace());
  axis.following_error_timeout = std::chrono::milliseconds{reader.integer_or(
      "following_error_timeout_ms",
      std::chrono::duration_cast<std::chrono::milliseconds>(axis.following_error_timeout).count(), 0, kLongestMs)};
}

/// Reads friction and weight of an axis.
void read_feed_forward(TomlReader& reader, motion::AxisConfig& axis) {
  constexpr double kMaxLoadValue = 1e6;
  // An axis slower than this share of its highest velocity counts as being at standstill.
  constexpr double kStandstill = 1e-3;
  auto& load = axis.feed_forward;
  load.viscous_friction = reader.number_or("viscous_friction", 0.0, 0.0, kMaxLoadValue);
  load.coulomb_friction = reader.number_or("coulomb_friction", 0.0, 0.0, kMaxLoadValue);
  load.coulomb_velocity = kStandstill * axis.limits.max_velocity;
  read_in_unit(reader, "coulomb_velocity", axis, 1e-9, kMaxLoadValue, load.coulomb_velocity);
  load.gravity = reader.number_or("gravity", 0.0, -kMaxLoadValue, kMaxLoadValue);
  load.pendulum = reader.number_or("pendulum", 0.0, 0.0, kMaxLoadValue);
  if (load.pendulum > 0.0 && axis.linear())
    reader.fail("pendulum", "is for rotary axes, but feed_mm_per_revolution makes this axis linear");
  read_in_unit(reader, "pendulum_zero", axis, -kMaxLoadValue, kMaxLoadValue, load.pendulum_zero);
}

/// Checks that friction and weight can reach the drive: as torque offsets, except in CST, where the target includes
/// them.
void check_feed_forward(const TomlReader& reader, const LineConfig& config, const SlaveConfig& slave,
                        const motion::AxisConfig& axis) {
  if (!axis.feed_forward.any() || axis.mode == motion::cia402::Mode::kCyclicTorque) return;
  const auto why = drive_rules(config, slave).why_no_torque_offset();
  if (!why.empty())
    reader.fail("", fmt::format("feed-forward of friction or gravity has no effect: \"{}\" {}", slave.name, why));
}

/// Number of drives that the slave can have: the description may give the identity of a device that is not known here.
unsigned drives_of(const SlaveConfig& slave) {
  const auto expected = expected_identity(slave);
  const auto known = slave.device->identity();
  const bool same = expected.vendor_id == known.vendor_id && expected.product_code == known.product_code;
  return same ? slave.device->drives() : motion::kMaxDrives;
}

/// Reads which drive of its slave moves the axis.
std::uint8_t read_drive_number(TomlReader& reader, const SlaveConfig& slave, const motion::AxisConfig& axis,
                               const std::vector<motion::AxisConfig>& others) {
  const auto drives = drives_of(slave);
  const auto drive = static_cast<std::uint8_t>(reader.integer_or("drive", 0, 0, motion::kMaxDrives - 1));
  if (drive >= drives) {
    reader.fail("drive",
                drives == 1 ? fmt::format("\"{}\" has one drive, 0 is expected", slave.name)
                            : fmt::format("\"{}\" has {} drives, 0 to {} is expected", slave.name, drives, drives - 1));
  }
  const auto other = std::find_if(others.begin(), others.end(),
                                  [&](const auto& one) { return one.slave == axis.slave && one.drive == drive; });
  if (other == others.end()) return drive;
  if (drives == 1) reader.fail("slave", fmt::format("\"{}\" already belongs to another axis", slave.name));
  reader.fail(reader.has("drive") ? "drive" : "slave",
              fmt::format("drive {} of \"{}\" already belongs to the axis \"{}\"", drive, slave.name, other->name));
}

motion::AxisConfig read_axis(TomlReader reader, const std::filesystem::path& directory, const LineConfig& config,
                             std::optional<motion::cia402::Mode> mode) {
  const auto& slaves = config.slaves;
  const auto& others = config.axes;
  motion::AxisConfig axis;
  axis.name = read_axis_name(reader, others);
  const auto slave_name = reader.text_or("slave", axis.name);
  const auto slave =
      std::find_if(slaves.begin(), slaves.end(), [&](const SlaveConfig& s) { return s.name == slave_name; });
  if (slave == slaves.end()) reader.fail("slave", fmt::format("there is no [[slave]] named \"{}\"", slave_name));
  axis.slave = static_cast<std::size_t>(slave - slaves.begin());
  if (const auto why = slave->device->why_no_axis(); !why.empty()) {
    reader.fail("slave", fmt::format("\"{}\" {}", slave_name, why));
  }
  axis.drive = read_drive_number(reader, *slave, axis, others);
  const auto chosen = reader.choice_or("mode", 0, motion::cia402::cyclic_mode_names());
  axis.mode = mode.value_or(motion::cia402::kCyclicModes.at(chosen));
  const auto defaults = drive_rules(config, *slave).axis_defaults();
  const double increments = reader.number_or("increments_per_revolution", defaults.increments_per_revolution, 1.0,
                                             kMaxIncrementsPerRevolution);
  if (reader.has("feed_mm_per_revolution")) axis.kind = trajectory::AxisKind::kLinear;
  axis.unit_per_revolution =
      axis.linear() ? reader.number("feed_mm_per_revolution", 1e-6, 1e6) / 1000.0 : 2.0 * std::numbers::pi;
  axis.increments_per_unit = increments / axis.unit_per_revolution;
  axis.scale_assumed = !reader.has("increments_per_revolution");
  axis.reversed = reader.choice_or("polarity", 0, {"normal", "reversed"}) == 1;
  axis.rated_torque =
      reader.number_or(axis.linear() ? "rated_force_n" : "rated_torque_nm", defaults.rated_torque, 1e-6, 1e6);
  axis.unit = read_unit(reader, axis.kind);
  axis.limits = defaults.limits;
  read_in_unit(reader, "max_velocity", axis, 1e-6, 1e6, axis.limits.max_velocity);
  read_in_unit(reader, "max_acceleration", axis, 1e-6, 1e9, axis.limits.max_acceleration);
  if (reader.has("max_jerk")) read_in_unit(reader, "max_jerk", axis, 1e-6, 1e12, axis.max_jerk.emplace());
  read_axis_range(reader, axis);
  if (reader.has("max_torque")) axis.max_torque = reader.number("max_torque", 1e-9, 1e6);
  axis.inertia = reader.number_or("inertia", 0.0, 0.0, 1e6);
  read_feed_forward(reader, axis);
  check_feed_forward(reader, config, *slave, axis);
  check_objects(reader, *slave, axis);
  axis.position_gain_1_s = reader.number_or("position_gain_1_s", axis.position_gain_1_s, 0.0, 1e4);
  read_velocity_gain(reader, axis);
  axis.adds_offsets = reader.boolean_or("adds_offsets", false);
  axis.velocity_by_factors = defaults.velocity_by_factors;
  axis.follow_bit = reader.boolean_or("follow_bit", defaults.follow_bit);
  if (reader.has("position_tolerance")) {
    read_in_unit(reader, "position_tolerance", axis, 0.0, 1e6, axis.position_tolerance.emplace());
  }
  read_following_error(reader, axis);
  constexpr double kLongestDelay = 10'000.0;
  if (reader.has("setpoint_delay_cycles"))
    axis.setpoint_delay_cycles = reader.number("setpoint_delay_cycles", 0.0, kLongestDelay);
  read_compensation(reader, directory, axis);
  reader.finish();
  return axis;
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

/// Refuses more tables than a line can have before they are read, which would take seconds.
void check_table_counts(const TomlReader& root, const toml::table& table) {
  for (const auto& [key, node] : table) {
    const auto* tables = node.as_array();
    const auto limit = key.str() == "slave" ? kMaxSlaves : kMaxTables;
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
  read_line(root.table("line"), config);
  DeviceFiles files(file.parent_path());
  read_bus(root.table("bus"), files, config);
  read_realtime(root.table("realtime"), config);
  for (auto& reader : root.tables("slave")) {
    config.slaves.push_back(read_slave(std::move(reader), config, files));
  }
  if (config.slaves.empty()) root.fail("", "there is no [[slave]]");
  read_simulation(root, config);
  if (root.has("eoe")) {
    read_eoe(root.table("eoe"), config);
  } else if (std::any_of(config.slaves.begin(), config.slaves.end(), [](const auto& slave) { return slave.ip; })) {
    root.fail("", "a [[slave]] has an ip, but there is no [eoe] table with its interface");
  }
  if (root.has("gateway")) config.gateway = read_gateway(root.table("gateway"), config.slaves);
  if (root.has("dc")) config.clocks = read_clocks(root.table("dc"), config.period, config.slaves);
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
  if (text.size() > kMaxDescriptionBytes) {
    return fail_file(name,
                     fmt::format("is larger than {} MiB, the limit of a line description", kMaxDescriptionBytes >> 20));
  }
  if (const auto line = too_deep_line(text)) {
    return fail_file(
        name, fmt::format("keys or values are more than {} levels deep; a line description needs four", kMaxTomlDepth),
        *line);
  }
  try {
    return read_config(toml::parse(text, name.string()), name, devices, mode);
  } catch (const toml::parse_error& error) {
    return fail_file(name, std::string(error.description()), error.source().begin.line);
  } catch (const ConfigError& wrong) {
    return tl::unexpected(wrong.error);
  }
}

Result<LineConfig> load_line_config(const std::filesystem::path& file, const DeviceRegistry& devices,
                                    std::optional<motion::cia402::Mode> mode) {
  const auto text = read_input_file(file);
  if (!text) return tl::unexpected(text.error());
  return parse_line_config(*text, file, devices, mode);
}

}  // namespace driveline::runtime
