#include "driveline/runtime/setup/composition.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <optional>

#include "driveline/esi/sii.hpp"
#include "driveline/motion/axis/startup_sdos.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/setup/wire_budget.hpp"
#include "driveline/slaves/persona/persona_slave.hpp"

namespace driveline::runtime {
namespace {

/// Returns the EEPROM content `image` with another station alias.
std::vector<std::byte> with_alias(std::vector<std::byte> image, std::uint16_t alias) {
  constexpr std::size_t kAlias = 8;
  constexpr std::size_t kChecksum = 14;
  bytes::store_le<std::uint16_t>(std::span(image).subspan(kAlias, 2), alias);
  const auto area = std::span<const std::byte>(image).first<esi::SiiConfigArea::kSize>();
  image[kChecksum] = static_cast<std::byte>(esi::sii_checksum(area));
  return image;
}

/// Returns the serial number that the line description expects; if it accepts several, the number on the line if that
/// is accepted.
std::uint32_t serial_number_of(const SlaveConfig& config, std::uint32_t number) {
  return config.plan.serial.accepts(number) ? number : config.plan.serial.value;
}

std::unique_ptr<slaves::Slave> make_slave(const SlaveConfig& config, std::uint32_t number) {
  slaves::SlaveOptions options;
  options.clock.drift_ppm = config.dc.drift_ppm;
  options.al.device_id = config.plan.device_id.value_or(0);
  options.sii_image = config.sii_content;
  auto device = config.device->simulate({config.name, serial_number_of(config, number)});
  // Give the simulated slave the alias that the description expects.
  if (options.sii_image.empty() && config.plan.alias)
    options.sii_image = with_alias(device->profile().sii_image, *config.plan.alias);
  return slaves::make_persona_slave(std::move(device), options, config.personas);
}

/// Whether the slave keeps its PDOs: the standard ones of an axis contain the objects of one drive only.
bool uses_own_pdos(const SlaveConfig& slave, std::span<const motion::AxisConfig* const> axes) {
  if (slave.plan.pdos) return false;
  return axes.size() != 1 || axes.front()->drive != 0 || slave.device->keeps_own_pdos();
}

/// Writes the range of an axis with a modulo; other axes keep the range of their drive.
void add_range(const motion::AxisConfig& axis, std::vector<motion::StartupSdo>& sdos) {
  if (axis.range_min >= axis.range_max) return;
  sdos.push_back(motion::startup_sdo(0x607B, 1, axis.range_min));
  sdos.push_back(motion::startup_sdo(0x607B, 2, axis.range_max));
}

/// Time from the frames to SYNC0 of a slave, and cycle of SYNC0.
struct SyncPlace {
  std::chrono::nanoseconds to_sync0{};
  std::chrono::nanoseconds cycle{};
};

/// `slave`: number of the [[slave]]. None: it has no SYNC0.
std::optional<SyncPlace> sync_place(std::size_t slave, const ecat_master::Master& master) {
  const auto position = master.position_of(slave).value_or(slave);
  const auto* clocks = master.clocks();
  if (clocks == nullptr || position >= clocks->slaves.size() || !clocks->slaves[position].signals.sync0())
    return std::nullopt;
  const auto& signals = clocks->slaves[position].signals;
  const auto cycle = std::max(signals.sync0_cycle, std::chrono::nanoseconds{1});
  return SyncPlace{((clocks->frame_lead + signals.sync0_shift) % cycle + cycle) % cycle, cycle};
}

motion::SetpointDelays setpoint_delays(const LineConfig& config, const motion::AxisConfig& axis,
                                       const ecat_master::Master& master) {
  motion::SetpointDelays delays;
  const auto& slave = config.slaves[axis.slave];
  delays.period = config.period;
  delays.divider = exchange_divider(config, slave);
  delays.interpolation = drive_rules(config, slave).interpolation_exchanges();
  if (const auto place = sync_place(axis.slave, master)) delays.to_sync0 = place->to_sync0;
  return delays;
}

/// Returns the cycles by which a torque offset is delayed: the drive interpolates towards a setpoint after receiving
/// it, but uses the offset at once, so the offset belongs to the middle of the interpolation. If only the inertia is
/// fed forward, the offset is sent with the setpoint.
double offset_delay(double setpoint_delay_cycles, motion::SetpointDelays delays) {
  delays.interpolation = 0;
  const double interpolation = setpoint_delay_cycles - motion::setpoint_delay_cycles(delays);
  return std::max(interpolation - 0.5 * delays.divider, 0.0);
}

}  // namespace

std::vector<std::unique_ptr<slaves::Slave>> make_simulated_slaves(const LineConfig& config) {
  std::vector<std::unique_ptr<slaves::Slave>> slaves;
  for (const auto& slave : config.slaves)
    slaves.push_back(make_slave(slave, static_cast<std::uint32_t>(slaves.size() + 1)));
  return slaves;
}

std::unique_ptr<slaves::SimulatedLine> make_simulated_line(const LineConfig& config, rt::Clock& clock,
                                                           bool second_interface) {
  slaves::LineOptions options;
  for (const auto& slave : config.slaves) options.slave_delays.push_back(slave.delays);
  auto line = std::make_unique<slaves::SimulatedLine>(clock, make_simulated_slaves(config), options, config.wiring);
  const auto far_end = line->wiring().master(slaves::MasterPort::kSecondary);
  if (far_end && !second_interface) line->break_cable(*far_end);
  for (const auto& plan : config.faults) line->faults().schedule(clock.now() + plan.at, plan.fault);
  return line;
}

std::vector<const motion::AxisConfig*> axes_of_slave(const LineConfig& config, std::size_t slave) {
  std::vector<const motion::AxisConfig*> axes;
  for (const auto& axis : config.axes) {
    if (axis.slave == slave) axes.push_back(&axis);
  }
  return axes;
}

std::vector<motion::StartupSdo> axis_startup_sdos(const LineConfig& config, const motion::AxisConfig& axis,
                                                  bool has_mode) {
  const auto& slave = config.slaves[axis.slave];
  auto sdos = drive_rules(config, slave).startup_sdos(axis, config.period * exchange_divider(config, slave));
  add_range(axis, sdos);
  if (!has_mode) sdos.push_back(motion::mode_sdo(axis.mode));
  for (auto& sdo : sdos) sdo.index = motion::object_of_drive(sdo.index, axis.drive);
  return sdos;
}

std::vector<ecat_master::SlavePlan> make_slave_plans(const LineConfig& config) {
  std::vector<ecat_master::SlavePlan> plans;
  for (std::size_t i = 0; i < config.slaves.size(); ++i) {
    const auto& slave = config.slaves[i];
    ecat_master::SlavePlan plan;
    plan.name = slave.name;
    plan.esi = slave.esi;
    const auto identity = expected_identity(slave);
    plan.vendor_id = identity.vendor_id;
    plan.product_code = identity.product_code;
    const auto axes = axes_of_slave(config, i);
    plan.own_pdos = uses_own_pdos(slave, axes);
    const bool standard = !plan.own_pdos && !slave.plan.pdos;
    if (standard) plan.pdos = motion::axis_pdo_configuration();
    for (const auto* axis : axes) {
      const auto sdos = axis_startup_sdos(config, *axis, standard);
      plan.startup_sdos.insert(plan.startup_sdos.end(), sdos.begin(), sdos.end());
    }
    slave.plan.apply(plan);
    plan.group = slave.group;
    plans.push_back(std::move(plan));
  }
  return plans;
}

std::chrono::nanoseconds input_age(std::size_t slave, const ecat_master::Master& master) {
  const auto place = sync_place(slave, master);
  return place ? (place->cycle - place->to_sync0) % place->cycle : std::chrono::nanoseconds{0};
}

double setpoint_delay(const LineConfig& config, const motion::AxisConfig& axis, const ecat_master::Master& master) {
  return motion::setpoint_delay_cycles(setpoint_delays(config, axis, master));
}

std::vector<motion::Axis> make_axes(const LineConfig& config, const ecat_master::Master& master) {
  std::vector<motion::Axis> axes;
  for (auto axis : config.axes) {
    axis.on_loss = config.recovery.axes;
    axis.period = config.period;
    if (axis.is_virtual()) {
      axes.emplace_back(std::move(axis));
      continue;
    }
    const auto delays = setpoint_delays(config, axis, master);
    if (!axis.setpoint_delay_cycles) axis.setpoint_delay_cycles = motion::setpoint_delay_cycles(delays);
    if (axis.feed_forward.any()) axis.offset_delay_cycles = offset_delay(*axis.setpoint_delay_cycles, delays);
    // The description names slaves; those with an alias may be anywhere on the line. All are present, otherwise
    // configure() would have failed.
    axis.slave = master.position_of(axis.slave).value_or(axis.slave);
    const auto& plan = master.slaves()[axis.slave].plan;
    // The loss of a hot-connect slave does not stop the others.
    if (plan.hot_connect) axis.on_loss = motion::LossPolicy::kContinue;
    axes.emplace_back(axis, master.image().places()[axis.slave].image_place(), plan.pdos);
  }
  return axes;
}

namespace {

/// Returns the limit of lost exchanges as a time; 0: the file gives it as a number.
std::chrono::nanoseconds lost_time(const LineConfig& config) {
  return config.max_lost_ms ? config.max_lost_cycles * config.period : std::chrono::nanoseconds{0};
}

}  // namespace

motion::Motion::Settings motion_settings(const LineConfig& config) {
  motion::Motion::Settings settings;
  settings.period = config.period;
  settings.repeat = config.path && config.path->repeat;
  settings.relative = !config.path || config.path->relative;
  settings.bad_cycle_limit = config.max_lost_cycles;
  settings.bad_time_limit = lost_time(config);
  if (config.path) settings.late = config.path->late;
  settings.compensate_dead_time = compensates_dead_time(config);
  return settings;
}

motion::SingleAxes::Settings single_axis_settings(const LineConfig& config) {
  motion::SingleAxes::Settings settings;
  settings.period = config.period;
  settings.bad_cycle_limit = config.max_lost_cycles;
  settings.bad_time_limit = lost_time(config);
  return settings;
}

ecat_master::CyclicCore::Settings cycle_settings(const LineConfig& config, const ecat_master::Master& master) {
  ecat_master::CyclicCore::Settings settings;
  settings.period = config.period;
  settings.receive_window = receive_window(config.period);
  settings.receive = config.receive;
  settings.acyclic_bytes = wire_budget(master, config).acyclic_bytes;
  return settings;
}

std::vector<SlaveConfig> describe_found(std::span<const ecat_master::ConfiguredSlave> found) {
  std::vector<SlaveConfig> slaves;
  for (const auto& one : found) {
    SlaveConfig slave;
    slave.name = fmt::format("slave{}", one.info.ref.position);
    slave.vendor_id = one.info.description.vendor_id;
    slave.product_code = one.info.description.product_code;
    slaves.push_back(std::move(slave));
  }
  return slaves;
}

std::vector<std::optional<std::size_t>> tables_of(const LineConfig& config,
                                                  std::span<const ecat_master::ConfiguredSlave> slaves) {
  std::vector<ecat_master::SlaveInfo> infos;
  for (const auto& slave : slaves) infos.push_back(slave.info);
  const auto plans = make_slave_plans(config);
  const auto comparison = ecat_master::compare_line(ecat_master::expected_slaves(plans), infos, {});
  if (comparison.matches()) return comparison.plan_of_slave;
  std::vector<std::optional<std::size_t>> tables(slaves.size());
  for (std::size_t i = 0; i < std::min(tables.size(), config.slaves.size()); ++i) tables[i] = i;
  return tables;
}

}  // namespace driveline::runtime
