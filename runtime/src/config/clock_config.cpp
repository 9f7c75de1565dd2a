#include "config/clock_config.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "toml/duration.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

constexpr double kMaxCycleUs = 4'294'967.0;
/// Oscillators of real slaves are within 100 ppm; a simulated one may exceed that limit of the standard.
constexpr double kMaxDriftPpm = 1000.0;
/// The data sheets state up to 40 ns; a gateway adds more.
constexpr double kMaxProcessingExtraNs = 10'000.0;

}  // namespace

ClockConfig read_clocks(TomlReader reader, nanoseconds period, const std::vector<SlaveConfig>& slaves) {
  using ecat_master::dc::FollowMode;
  ClockConfig clocks;
  constexpr FollowMode kModes[] = {FollowMode::kMasterFollows, FollowMode::kReferenceFollows};
  clocks.mode = kModes[reader.choice_or("mode", 0, {"master_follows", "reference_follows"})];
  using Time = ClockConfig::Time;
  constexpr Time kTimes[] = {Time::kMonotonic, Time::kSystem, Time::kTai};
  clocks.time = kTimes[reader.choice_or("time", 0, {"monotonic", "system", "tai"})];
  if (reader.has("reference")) {
    const auto name = reader.text("reference");
    const auto found =
        std::find_if(slaves.begin(), slaves.end(), [&](const auto& slave) { return slave.name == name; });
    if (found == slaves.end()) reader.fail("reference", fmt::format("there is no [[slave]] named \"{}\"", name));
    clocks.reference = static_cast<std::uint16_t>(found - slaves.begin());
  }
  const double period_us = static_cast<double>(period.count()) / 1000.0;
  clocks.frame_lead = from_us(reader.number_or("frame_lead_us", period_us / 2.0, 0.0, period_us));
  reader.finish();
  return clocks;
}

SlaveClockConfig read_slave_clock(TomlReader reader) {
  SlaveClockConfig clock;
  clock.synchronous = reader.boolean_or("synchronous", true);
  if (reader.has("op_mode")) clock.op_mode = reader.text("op_mode");
  auto time = [&reader](std::string_view key, double minimum) -> std::optional<nanoseconds> {
    if (!reader.has(key)) return std::nullopt;
    return from_us(reader.number(key, minimum, kMaxCycleUs));
  };
  clock.sync0_cycle = time("sync0_cycle_us", 0.0);
  clock.sync0_shift = time("sync0_shift_us", -kMaxCycleUs);
  clock.sync1_cycle = time("sync1_cycle_us", 0.0);
  clock.sync1_shift = time("sync1_shift_us", 0.0);
  clock.processing_extra_ns = reader.number_or("processing_extra_ns", 0.0, 0.0, kMaxProcessingExtraNs);
  clock.drift_ppm = reader.number_or("drift_ppm", 0.0, -kMaxDriftPpm, kMaxDriftPpm);
  reader.finish();
  return clock;
}

}  // namespace driveline::runtime
