#include "config/clock_plan.hpp"

#include <fmt/format.h>
#include <algorithm>

namespace driveline::cli {
namespace {

using ecat_master::dc::from_op_mode;
using ecat_master::dc::SyncSignals;

/// MSD manual 9.1: the cycle time is a multiple of 125 us.
constexpr std::chrono::microseconds kMsdTimeBase{125};

/// Null: the master's own clock.
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

/// Operation modes of a slave: those of its ESI file, else those of its EEPROM.
std::vector<esi::DcOpMode> modes_of(const LineConfig& line, const SlaveConfig& slave,
                                    const esi::DeviceDescription& found) {
  auto file = slave.esi;
  if (!file && line.esi_library) file = line.esi_library->find(found.vendor_id, found.product_code, found.revision);
  return file && !file->dc_modes.empty() ? file->dc_modes : found.dc_modes;
}

Outcome<SyncSignals> signals_of(const SlaveConfig& config, const std::vector<esi::DcOpMode>& modes,
                                std::chrono::nanoseconds period) {
  SyncSignals signals{ecat_master::dc::kActivateSync0, period, {}, {}, {}};
  const auto wanted = [&](const esi::DcOpMode& mode) {
    return config.dc.op_mode ? mode.name == *config.dc.op_mode : from_op_mode(mode, period).sync0();
  };
  const auto mode = std::find_if(modes.begin(), modes.end(), wanted);
  if (mode != modes.end()) {
    signals = from_op_mode(*mode, period);
  } else if (config.dc.op_mode) {
    return misused(fmt::format("slave {}: has no operation mode \"{}\", its description knows {}", config.name,
                               *config.dc.op_mode, known_modes(modes)));
  }
  signals.sync0_cycle = config.dc.sync0_cycle.value_or(signals.sync0_cycle);
  signals.sync0_shift = config.dc.sync0_shift.value_or(signals.sync0_shift);
  signals.sync1_cycle = config.dc.sync1_cycle.value_or(signals.sync1_cycle);
  signals.sync1_shift = config.dc.sync1_shift.value_or(signals.sync1_shift);
  // Who asks for SYNC1 times wants SYNC1.
  if (config.dc.sync1_cycle || config.dc.sync1_shift) signals.assign_activate |= 0x0400U;
  return signals;
}

}  // namespace

Outcome<ecat_master::dc::ClockPlan> make_clock_plan(const LineConfig& config,
                                                    std::span<const ecat_master::ConfiguredSlave> slaves,
                                                    bool virtual_time) {
  ecat_master::dc::ClockPlan plan;
  plan.mode = config.clocks->mode;
  if (!virtual_time) plan.time = time_source(config.clocks->time);
  plan.reference = config.clocks->reference;
  plan.period = config.period;
  plan.frame_lead = config.clocks->frame_lead;
  for (std::size_t i = 0; i < std::min(config.slaves.size(), slaves.size()); ++i) {
    auto& slave = plan.slaves.emplace_back();
    slave.processing_extra_ns = config.slaves[i].dc.processing_extra_ns;
    if (!config.slaves[i].dc.synchronous) continue;
    auto signals = signals_of(config.slaves[i], modes_of(config, config.slaves[i], slaves[i].info.description),
                              config.period * exchange_divider(config, config.slaves[i]));
    if (!signals) return tl::unexpected(signals.error());
    slave.signals = *signals;
    if (!config.slaves[i].device) slave.base = kMsdTimeBase;
  }
  return plan;
}

}  // namespace driveline::cli
