#include "devices/msd/drive_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "devices/signal_reader.hpp"

namespace driveline::runtime {
namespace {

using slaves::msd::FirmwareVersion;
using slaves::msd::MachineSwitch;
using slaves::msd::MsdParameters;
using slaves::msd::ScriptedSignal;
using Direction = slaves::SignalId::Direction;

constexpr double kRevolution = 2.0 * std::numbers::pi;
constexpr double kRpm = kRevolution / 60.0;
/// Smallest inertia in kg m^2, that of the smallest servo motors; not 0, because it is a divisor.
constexpr double kMinInertia = 1e-6;
constexpr double kMaxWayRev = 1e6;

/// All numbers of the machine, in the order of the reference.
constexpr std::array kPlantKeys = {
    PlantKey{"plant", "inertia_kg_m2", "kg m²", kMinInertia, 10.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.inertia_kg_m2}; }},
    PlantKey{"plant", "viscous_friction_nm_s", "Nm s/rad", 0.0, 100.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.viscous_friction_nm_s}; }},
    PlantKey{"plant", "coulomb_friction_nm", "Nm", 0.0, 1000.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.coulomb_friction_nm}; }},
    PlantKey{"plant", "initial_position_rev", "revolutions", -1000.0, 1000.0, kRevolution,
             [](MsdParameters& p) { return PlantKey::Place{&p.initial_position_rad}; }},
    PlantKey{"plant", "rated_torque_nm", "Nm", 1e-3, 1e5, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.rated_torque_nm}; }},
    PlantKey{"plant", "peak_torque_nm", "Nm", 1e-3, 1e5, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.peak_torque_nm}; }},
    PlantKey{"plant", "rated_current_a", "A", 0.01, 1e4, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.rated_current_a}; }},
    PlantKey{"plant", "rated_speed_rpm", "1/min", 10.0, 1e5, kRpm,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.rated_speed_rad_s}; }},
    PlantKey{"plant", "max_speed_rpm", "1/min", 10.0, 1e5, kRpm,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.max_speed_rad_s}; }},
    PlantKey{"plant", "pole_pairs", "", 1.0, 100.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.pole_pairs}; }},
    PlantKey{"plant", "torque_lag_us", "µs", 0.0, 10000.0, 1e-6,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.torque_lag_s}; }},
    PlantKey{"plant", "brake_torque_nm", "Nm", 0.0, 1e5, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.brake_torque_nm}; }},
    PlantKey{"plant", "dc_link_v", "V", 0.0, 1000.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.dc_link_volts}; }},
    PlantKey{"plant.dc_link", "capacitance_uf", "µF", 1.0, 1e6, 1e-6,
             [](MsdParameters& p) { return PlantKey::Place{&p.dc_link.capacitance_f}; }},
    PlantKey{"plant.dc_link", "brake_chopper_v", "V", 0.0, 1000.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.dc_link.chopper_volts}; }},
    PlantKey{"plant.dc_link", "brake_resistor_ohm", "Ω", 0.0, 1e4, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.dc_link.brake_resistor_ohm}; }},
    PlantKey{"plant.dc_link", "standby_w", "W", 0.0, 1e4, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.dc_link.standby_w}; }},
    PlantKey{"plant.thermal", "motor_time_constant_s", "s", 0.01, 1e5, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.thermal.motor_time_constant_s}; }},
    PlantKey{"plant.thermal", "motor_rise_k", "K", 0.0, 1000.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.thermal.motor_rise_k}; }},
    PlantKey{"plant.thermal", "amplifier_time_constant_s", "s", 0.01, 1e5, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.thermal.amplifier_time_constant_s}; }},
    PlantKey{"plant.thermal", "amplifier_rise_k", "K", 0.0, 1000.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.thermal.amplifier_rise_k}; }},
    PlantKey{"plant.thermal", "ambient_c", "°C", -40.0, 150.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.thermal.ambient_c}; }},
    PlantKey{"plant.winding", "resistance_ohm", "Ω", 1e-3, 1e4, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.winding.resistance_ohm}; }},
    PlantKey{"plant.winding", "inductance_mh", "mH", 1e-3, 1e4, 1e-3,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.winding.inductance_h}; }},
    PlantKey{"plant.winding", "saturation_current_a", "A", 0.0, 1e4, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.winding.saturation_current_a}; }},
    PlantKey{"plant.encoder", "increments_per_revolution", "", 4.0, 268435456.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.encoder_increments}; }},
    PlantKey{"plant.encoder", "turns", "", 0.0, 65536.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.encoder_turns}; }},
    PlantKey{"plant.encoder", "noise_increments", "increments", 0.0, 1e6, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.encoder_noise_increments}; }},
    PlantKey{"plant.encoder", "seed", "", 1.0, 4294967295.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.encoder_seed}; }},
    PlantKey{"plant.load", "inertia_kg_m2", "kg m²", 0.0, 1000.0, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.inertia_kg_m2}; }},
    PlantKey{"plant.load", "stiffness_nm_rad", "Nm/rad", 0.01, 1e7, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.stiffness_nm_rad}; }},
    PlantKey{"plant.load", "damping_nm_s", "Nm s/rad", 0.0, 1e4, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.damping_nm_s}; }},
    PlantKey{"plant.load", "coulomb_friction_nm", "Nm", 0.0, 1e5, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.coulomb_friction_nm}; }},
    PlantKey{"plant.load", "gravity_nm", "Nm", -1e5, 1e5, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.gravity_nm}; }},
    PlantKey{"plant.load", "end_stop_min_rev", "revolutions", -kMaxWayRev, kMaxWayRev, kRevolution,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.end_stop_min_rad}; }},
    PlantKey{"plant.load", "end_stop_max_rev", "revolutions", -kMaxWayRev, kMaxWayRev, kRevolution,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.end_stop_max_rad}; }},
    PlantKey{"plant.load", "end_stop_stiffness_nm_rad", "Nm/rad", 1.0, 1e7, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.end_stop_stiffness_nm_rad}; }},
    PlantKey{"plant.load", "end_stop_damping_nm_s", "Nm s/rad", 0.0, 1e4, 1.0,
             [](MsdParameters& p) { return PlantKey::Place{&p.motor.load.end_stop_damping_nm_s}; }},
};

/// Reads the numbers of a table into the model.
void read_numbers(TomlReader& reader, std::string_view table, MsdParameters& parameters) {
  for (const PlantKey& row : kPlantKeys) {
    if (row.table != table || !reader.has(row.key)) continue;
    const auto place = row.place(parameters);
    if (auto* const* number = std::get_if<std::uint32_t*>(&place)) {
      **number = static_cast<std::uint32_t>(
          reader.integer(row.key, static_cast<std::int64_t>(row.minimum), static_cast<std::int64_t>(row.maximum)));
    } else {
      *std::get<double*>(place) = reader.number(row.key, row.minimum, row.maximum) * row.scale;
    }
  }
}

void read_motor(TomlReader& reader, MsdParameters& parameters) {
  read_numbers(reader, "plant", parameters);
  const auto& motor = parameters.motor;
  if (reader.has("rated_torque_nm") && !reader.has("peak_torque_nm")) {
    // The standard motor has a peak torque of three times the rated torque.
    parameters.motor.peak_torque_nm = 3.0 * motor.rated_torque_nm;
  }
  if (motor.peak_torque_nm < motor.rated_torque_nm) {
    reader.fail("peak_torque_nm", fmt::format("is {}, at least rated_torque_nm, {}, is expected", motor.peak_torque_nm,
                                              motor.rated_torque_nm));
  }
  if (reader.has("max_speed_rpm") && !reader.has("rated_speed_rpm")) {
    parameters.motor.rated_speed_rad_s = 0.5 * motor.max_speed_rad_s;
  }
  if (motor.max_speed_rad_s < motor.rated_speed_rad_s) {
    reader.fail("rated_speed_rpm", fmt::format("is {:.6g}, at most max_speed_rpm, {:.6g}, is expected",
                                               motor.rated_speed_rad_s / kRpm, motor.max_speed_rad_s / kRpm));
  }
  if (!reader.has("rated_current_a")) parameters.motor.rated_current_a = motor.typical_current_a();
}

/// Sets missing winding data to those of a typical motor of the same rating.
void complete_winding(TomlReader& reader, MsdParameters& parameters) {
  const auto typical = parameters.motor.typical_winding();
  if (!reader.has("resistance_ohm")) parameters.motor.winding.resistance_ohm = typical.resistance_ohm;
  if (!reader.has("inductance_mh")) parameters.motor.winding.inductance_h = typical.inductance_h;
}

void read_load(TomlReader reader, MsdParameters& parameters) {
  read_numbers(reader, "plant.load", parameters);
  const auto& load = parameters.motor.load;
  for (const std::string_view key : {"stiffness_nm_rad", "damping_nm_s"}) {
    if (!reader.has(key) || load.inertia_kg_m2 > 0.0) continue;
    reader.fail(key, "is for a coupling to a load: set inertia_kg_m2 of the load");
  }
  if (load.end_stop_min_rad >= load.end_stop_max_rad) {
    reader.fail("end_stop_max_rev",
                fmt::format("is {}, more than end_stop_min_rev, {}, is expected", load.end_stop_max_rad / kRevolution,
                            load.end_stop_min_rad / kRevolution));
  }
  reader.finish();
}

void read_plant(TomlReader reader, MsdParameters& parameters) {
  read_motor(reader, parameters);
  parameters.motor.winding.simulated = reader.has("winding");
  for (const std::string_view name : {"winding", "encoder", "dc_link", "thermal"}) {
    auto table = reader.table(name);
    read_numbers(table, fmt::format("plant.{}", name), parameters);
    if (name == "winding") complete_winding(table, parameters);
    table.finish();
  }
  read_load(reader.table("load"), parameters);
  reader.finish();
}

std::optional<FirmwareVersion> read_firmware(TomlReader& slave, const slaves::msd::VariantFacts& facts) {
  if (!slave.has("firmware")) return std::nullopt;
  const auto firmware = FirmwareVersion::parse(slave.text("firmware"));
  const auto as_long = [](const FirmwareVersion& version) { return version.text().size(); };
  if (!firmware || *firmware < facts.oldest || as_long(*firmware) > as_long(facts.firmware)) {
    slave.fail("firmware",
               fmt::format("must be a version as \"{}\", from {} on", facts.firmware.text(), facts.oldest.text()));
  }
  return firmware;
}

/// Returns the number of the input named by `key`.
std::size_t read_input_name(TomlReader& reader, std::string_view key) {
  const auto name = reader.text(key);
  const auto place = slaves::msd::find_drive_signal(Direction::kInput, name);
  if (!place) reader.fail(key, fmt::format("\"{}\" {}", name, describe(place.error())));
  return place->number;
}

MachineSwitch read_switch(TomlReader reader) {
  MachineSwitch result;
  const auto terminal = slaves::msd::input_terminal(read_input_name(reader, "input"));
  if (!terminal) reader.fail("input", "is not a terminal, but a switch needs one");
  result.input = *terminal;
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const auto way = [&reader](std::string_view key, double fallback) {
    return reader.has(key) ? reader.number(key, -kMaxWayRev, kMaxWayRev) * kRevolution : fallback;
  };
  result.from_rad = way("from_rev", -kEndless);
  result.to_rad = way("to_rev", kEndless);
  if (std::isinf(result.from_rad) && std::isinf(result.to_rad)) {
    reader.fail("", "from_rev or to_rev is missing: the position of the switch is expected");
  }
  if (result.from_rad >= result.to_rad) {
    reader.fail("to_rev", fmt::format("is {}, more than from_rev, {}, is expected", result.to_rad / kRevolution,
                                      result.from_rad / kRevolution));
  }
  result.normally_closed = reader.boolean_or("normally_closed", false);
  reader.finish();
  return result;
}

ScriptedSignal read_input(TomlReader reader, const MsdParameters& parameters) {
  const auto input = read_input_name(reader, "entry");
  const auto same = [input](const ScriptedSignal& other) { return other.input == input; };
  if (std::any_of(parameters.inputs.begin(), parameters.inputs.end(), same)) {
    reader.fail("entry", "already has a script");
  }
  const auto terminal = slaves::msd::input_terminal(input);
  const auto switched = [&terminal](const MachineSwitch& s) { return terminal == s.input; };
  if (std::any_of(parameters.switches.begin(), parameters.switches.end(), switched)) {
    reader.fail("entry", "already has a [[slave.switch]]");
  }
  ScriptedSignal script{input, read_signal(reader)};
  if (!script.signal.jumps()) {
    reader.fail("shape", "is for numbers; \"constant\", \"toggle\" or \"steps\" is expected for an input of a drive");
  }
  for (const double value : {script.signal.smallest(), script.signal.largest()}) {
    const auto fits = slaves::msd::check_drive_input(input, value);
    if (!fits) reader.fail("entry", describe(fits.error()));
  }
  reader.finish();
  return script;
}

}  // namespace

bool PlantKey::integer() const noexcept {
  MsdParameters parameters;
  return std::holds_alternative<std::uint32_t*>(place(parameters));
}

double PlantKey::standard() const {
  MsdParameters parameters;
  return std::visit([this](const auto* value) { return static_cast<double>(*value) / scale; }, place(parameters));
}

std::span<const PlantKey> plant_keys() {
  return kPlantKeys;
}

MsdParameters read_drive_parameters(TomlReader& slave, slaves::msd::Variant variant,
                                    const std::filesystem::path& directory) {
  MsdParameters parameters;
  parameters.variant = variant;
  parameters.firmware = read_firmware(slave, slaves::msd::facts(variant));
  read_plant(slave.table("plant"), parameters);
  for (auto& reader : slave.tables("switch")) parameters.switches.push_back(read_switch(std::move(reader)));
  for (auto& reader : slave.tables("input")) parameters.inputs.push_back(read_input(std::move(reader), parameters));
  if (slave.has("parameter_file")) parameters.parameter_file = (directory / slave.text("parameter_file")).string();
  const auto read_time = [&slave](std::string_view key, std::chrono::nanoseconds& time) {
    if (slave.has(key)) time = std::chrono::nanoseconds{std::llround(slave.number(key, 0.125, 60000.0) * 1e6)};
  };
  read_time("start_up_ms", parameters.start_up_time);
  read_time("factory_start_up_ms", parameters.factory_start_up_time);
  parameters.file_password = static_cast<std::uint32_t>(
      slave.integer_or("file_password", parameters.file_password, 0, std::numeric_limits<std::uint32_t>::max()));
  return parameters;
}

}  // namespace driveline::runtime
