#include "config/axis_reader.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <numbers>

#include "config/axis_range_reader.hpp"
#include "config/can_restrictions.hpp"
#include "config/compensation_reader.hpp"
#include "devices/eds/eds_family.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/motion/drive/axis_objects.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/trajectory/axis_name.hpp"

namespace driveline::runtime {
namespace {

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
  if (!motion::cia402::cyclic(axis.mode)) {
    reader.fail("", fmt::format("feed-forward of friction or gravity has no effect: {} has no torque offset",
                                axis.mode == motion::cia402::Mode::kInterpolatedPosition ? "interpolated position"
                                                                                         : "a profile mode"));
  }
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

/// Finds the drive of the axis: its slave, and its number there. Returns the slave.
const SlaveConfig& read_drive(TomlReader& reader, const LineConfig& config, motion::AxisConfig& axis) {
  const auto& slaves = config.slaves;
  const auto name = reader.text_or("slave", axis.name);
  const auto slave = std::find_if(slaves.begin(), slaves.end(), [&](const SlaveConfig& s) { return s.name == name; });
  if (slave == slaves.end()) reader.fail("slave", fmt::format("there is no [[slave]] named \"{}\"", name));
  axis.slave = static_cast<std::size_t>(slave - slaves.begin());
  if (const auto why = slave->device->why_no_axis(); !why.empty()) {
    reader.fail("slave", fmt::format("\"{}\" {}", name, why));
  }
  axis.drive = read_drive_number(reader, *slave, axis, config.axes);
  return *slave;
}

/// Reads how positions and torques of the drive are those of the axis.
void read_scale(TomlReader& reader, const AxisDefaults& defaults, motion::AxisConfig& axis) {
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
}

/// Reads the limits of motions; unit and scale have been read.
void read_limits(TomlReader& reader, const AxisDefaults& defaults, motion::AxisConfig& axis) {
  axis.limits = defaults.limits;
  read_in_unit(reader, "max_velocity", axis, 1e-6, 1e6, axis.limits.max_velocity);
  read_in_unit(reader, "max_acceleration", axis, 1e-6, 1e9, axis.limits.max_acceleration);
  if (reader.has("max_jerk")) read_in_unit(reader, "max_jerk", axis, 1e-6, 1e12, axis.max_jerk.emplace());
  read_axis_range(reader, axis);
  if (reader.has("max_torque")) axis.max_torque = reader.number("max_torque", 1e-9, 1e6);
}

/// Reads the loops over the bus, and how the drive takes its setpoints.
void read_loops(TomlReader& reader, const AxisDefaults& defaults, motion::AxisConfig& axis) {
  axis.position_gain_1_s = reader.number_or("position_gain_1_s", axis.position_gain_1_s, 0.0, 1e4);
  read_velocity_gain(reader, axis);
  axis.adds_offsets = reader.boolean_or("adds_offsets", false);
  axis.velocity_by_factors = defaults.velocity_by_factors;
  axis.follow_bit = reader.boolean_or("follow_bit", defaults.follow_bit);
}

/// Reads what is supervised; the unit has been read.
void read_supervision(TomlReader& reader, motion::AxisConfig& axis) {
  constexpr double kLongestDelay = 10'000.0;
  if (reader.has("position_tolerance")) {
    read_in_unit(reader, "position_tolerance", axis, 0.0, 1e6, axis.position_tolerance.emplace());
  }
  read_following_error(reader, axis);
  if (reader.has("setpoint_delay_cycles"))
    axis.setpoint_delay_cycles = reader.number("setpoint_delay_cycles", 0.0, kLongestDelay);
}

motion::cia402::Mode read_cyclic_mode(TomlReader& reader, std::optional<motion::cia402::Mode> all) {
  const auto chosen = reader.choice_or("mode", 0, motion::cia402::cyclic_mode_names());
  return all.value_or(motion::cia402::kCyclicModes.at(chosen));
}

/// The only mode in which axes follow setpoints over a CAN bus is interpolated position. In the others the drive plans
/// the motions of its axis.
constexpr std::array kCanModes{motion::cia402::Mode::kInterpolatedPosition, motion::cia402::Mode::kProfilePosition,
                               motion::cia402::Mode::kProfileVelocity};

std::string names_of_can_modes() {
  return "\"ip\" (interpolated position), \"pp\" (profile position) or \"pv\" (profile velocity)";
}

/// Reads the mode of an axis on a CAN bus: by default the first of kCanModes that its drive has by its data sheet.
motion::cia402::Mode read_can_mode(TomlReader& reader, const SlaveConfig& slave, unsigned drive,
                                   std::optional<motion::cia402::Mode> all) {
  using motion::cia402::Mode;
  const auto name = reader.has("mode") ? reader.text("mode") : std::string();
  const auto cyclic = all ? all : motion::cia402::find_cyclic_mode(name);
  if (cyclic) reader.fail("mode", why_not_on_can(*cyclic));
  const auto named = [&](Mode mode) { return name.empty() || to_text(mode) == name; };
  if (std::none_of(kCanModes.begin(), kCanModes.end(), named)) {
    reader.fail("mode", fmt::format("is \"{}\", {} is expected", name, names_of_can_modes()));
  }
  const auto modes = modes_in_sheet(*slave.device, drive);
  const auto* const found = std::find_if(kCanModes.begin(), kCanModes.end(), [&](Mode mode) {
    return named(mode) && (!modes || (*modes & motion::cia402::mode_bit(mode)) != 0);
  });
  if (found != kCanModes.end()) return *found;
  reader.fail(name.empty() ? "slave" : "mode",
              fmt::format("6502h of \"{}\" is 0x{:08X} in its data sheet: it does not have {}", slave.name, *modes,
                          name.empty() ? names_of_can_modes() : fmt::format("mode \"{}\"", name)));
}

}  // namespace

motion::AxisConfig read_axis(TomlReader reader, const std::filesystem::path& directory, const LineConfig& config,
                             std::optional<motion::cia402::Mode> mode) {
  motion::AxisConfig axis;
  axis.name = read_axis_name(reader, config.axes);
  const auto& slave = read_drive(reader, config, axis);
  axis.mode = config.can ? read_can_mode(reader, slave, axis.drive, mode) : read_cyclic_mode(reader, mode);
  const auto defaults = drive_rules(config, slave).axis_defaults();
  read_scale(reader, defaults, axis);
  read_limits(reader, defaults, axis);
  axis.inertia = reader.number_or("inertia", 0.0, 0.0, 1e6);
  read_feed_forward(reader, axis);
  check_feed_forward(reader, config, slave, axis);
  check_objects(reader, slave, axis);
  read_loops(reader, defaults, axis);
  read_supervision(reader, axis);
  read_compensation(reader, directory, axis);
  reader.finish();
  return axis;
}

void complete_velocity_gains(LineConfig& config) {
  constexpr double kBandwidthPerS = 100.0;
  constexpr double kPerExchange = 0.2;
  for (auto& axis : config.axes) {
    if (axis.velocity_gain > 0.0 || axis.is_virtual()) continue;
    const std::chrono::duration<double> exchange = config.period * exchange_divider(config, config.slaves[axis.slave]);
    axis.velocity_gain = axis.inertia * std::min(kBandwidthPerS, kPerExchange / exchange.count());
  }
}

}  // namespace driveline::runtime
