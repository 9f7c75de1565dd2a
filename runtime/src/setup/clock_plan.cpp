#include "driveline/runtime/setup/clock_plan.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::dc::from_op_mode;
using ecat_master::dc::SlaveClockPlan;
using ecat_master::dc::SyncSignals;

/// Returns the time source; null: the master's own clock.
const ecat_master::dc::TimeSource* time_source(ClockConfig::Time time) {
  using ecat_master::dc::SystemTimeSource;
  static const SystemTimeSource kUtc(SystemTimeSource::Scale::kUtc);
  static const SystemTimeSource kTai(SystemTimeSource::Scale::kTai);
  switch (time) {
    case ClockConfig::Time::kMonotonic:
      return nullptr;
    case ClockConfig::Time::kSystem:
      return &kUtc;
    case ClockConfig::Time::kTai:
      return &kTai;
  }
  return nullptr;
}

std::string known_modes(const std::vector<esi::DcOpMode>& modes) {
  std::string names;
  for (const auto& mode : modes) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", mode.name);
  return names.empty() ? "none" : names;
}

/// Returns the operation modes of a slave: those of its ESI file, else those of its EEPROM.
std::vector<esi::DcOpMode> modes_of(const LineConfig& line, const SlaveConfig& slave,
                                    const esi::DeviceDescription& found) {
  auto file = slave.esi;
  if (!file && line.esi_library) file = line.esi_library->find(found.vendor_id, found.product_code, found.revision);
  return file && !file->dc_modes.empty() ? file->dc_modes : found.dc_modes;
}

Result<SyncSignals> signals_of(const SlaveConfig& config, const std::vector<esi::DcOpMode>& modes,
                               std::chrono::nanoseconds period) {
  SyncSignals signals{ecat_master::dc::kActivateSync0, period, {}, {}, {}};
  const auto wanted = [&](const esi::DcOpMode& mode) {
    return config.dc.op_mode ? mode.name == *config.dc.op_mode : from_op_mode(mode, period).sync0();
  };
  const auto mode = std::find_if(modes.begin(), modes.end(), wanted);
  if (mode != modes.end()) {
    signals = from_op_mode(*mode, period);
  } else if (config.dc.op_mode) {
    return fail(ErrorKind::kSetting, fmt::format("slave {}: has no operation mode \"{}\", its description knows {}",
                                                 config.name, *config.dc.op_mode, known_modes(modes)));
  }
  signals.sync0_cycle = config.dc.sync0_cycle.value_or(signals.sync0_cycle);
  signals.sync0_shift = config.dc.sync0_shift.value_or(signals.sync0_shift);
  signals.sync1_cycle = config.dc.sync1_cycle.value_or(signals.sync1_cycle);
  signals.sync1_shift = config.dc.sync1_shift.value_or(signals.sync1_shift);
  // SYNC1 times in the file switch SYNC1 on.
  if (config.dc.sync1_cycle || config.dc.sync1_shift) signals.assign_activate |= 0x0400U;
  return signals;
}

/// Returns the clock plan of the slave `found` by the line description.
Result<SlaveClockPlan> plan_of(const LineConfig& config, const SlaveConfig& slave,
                               const esi::DeviceDescription& found) {
  SlaveClockPlan plan;
  plan.processing_extra_ns = slave.dc.processing_extra_ns;
  if (!slave.dc.synchronous) return plan;
  const auto signals =
      signals_of(slave, modes_of(config, slave, found), config.period * exchange_divider(config, slave));
  if (!signals) return tl::unexpected(signals.error());
  plan.signals = *signals;
  plan.base = drive_rules(config, slave).clock_base();
  return plan;
}

}  // namespace

Result<ecat_master::dc::ClockPlan> make_clock_plan(const LineConfig& config,
                                                   std::span<const ecat_master::ConfiguredSlave> slaves,
                                                   bool virtual_time) {
  ecat_master::dc::ClockPlan plan;
  plan.mode = config.clocks->mode;
  if (!virtual_time) plan.time = time_source(config.clocks->time);
  plan.period = config.period;
  plan.frame_lead = config.clocks->frame_lead;
  const auto tables = tables_of(config, slaves);
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    auto& slave = plan.slaves.emplace_back();
    if (!tables[i]) continue;
    auto planned = plan_of(config, config.slaves[*tables[i]], slaves[i].info.description);
    if (!planned) return tl::unexpected(planned.error());
    slave = *planned;
  }
  if (const auto wanted = config.clocks->reference) {
    const auto found = std::find(tables.begin(), tables.end(), std::optional<std::size_t>(*wanted));
    if (found == tables.end()) {
      return fail(ErrorKind::kLine,
                  fmt::format("[dc] reference: slave \"{}\" is not on the line", config.slaves[*wanted].name));
    }
    plan.reference = static_cast<std::uint16_t>(found - tables.begin());
  }
  plan.may_join = std::any_of(config.slaves.begin(), config.slaves.end(),
                              [](const SlaveConfig& slave) { return slave.plan.hot_connect && slave.dc.synchronous; });
  plan.joining = [&config](std::size_t table, const esi::DeviceDescription& found) {
    const auto planned = plan_of(config, config.slaves[table], found);
    return planned ? ecat_master::Result<SlaveClockPlan>(*planned)
                   : tl::unexpected(ecat_master::Error{ecat_master::facts::NoClockMode{}});
  };
  return plan;
}

}  // namespace driveline::runtime
