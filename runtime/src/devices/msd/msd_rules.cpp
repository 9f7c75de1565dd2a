#include "devices/msd/msd_rules.hpp"

#include <bit>

namespace driveline::runtime {
namespace {

using motion::startup_sdo;

/// Returns the object of a manufacturer parameter: 2000h plus the parameter's number (MSD manual 8.2.3).
constexpr std::uint16_t parameter(unsigned number) {
  return static_cast<std::uint16_t>(0x2000 + number);
}

/// Source of the torque feed-forward (MSD manual Table 12.26): 60B2h instead of inertia times acceleration.
constexpr std::uint8_t kTorqueSource = 2;
constexpr std::uint16_t kExternal = 1;

motion::StartupSdo real_sdo(std::uint16_t index, double value) {
  return startup_sdo(index, 0, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

}  // namespace

std::vector<motion::StartupSdo> MsdRules::startup_sdos(const motion::AxisConfig& axis,
                                                       std::chrono::nanoseconds period) const {
  auto sdos = motion::cia402_startup_sdos(period);
  sdos.insert(sdos.begin(), real_sdo(parameter(306), std::chrono::duration<double, std::milli>(period).count()));
  // Required even if the axis starts in another mode, because it may change to CSP.
  constexpr std::uint8_t kCubicSpline = 3;
  sdos.push_back(startup_sdo(parameter(370), 0, kCubicSpline));
  if (axis.inertia > 0.0 && !axis.linear()) sdos.push_back(real_sdo(parameter(1516), axis.inertia));
  if (axis.feed_forward.any() && axis.mode != motion::cia402::Mode::kCyclicTorque) {
    sdos.push_back(startup_sdo(parameter(379), kTorqueSource, kExternal));
  }
  return sdos;
}

std::vector<motion::StartupSdo> MsdRules::sync_watch_sdos(std::chrono::milliseconds limit) const {
  constexpr std::uint8_t kSync = 0;
  return {startup_sdo(parameter(2061), 0, kSync),
          startup_sdo(parameter(2062), 0, static_cast<std::uint32_t>(limit.count()))};
}

}  // namespace driveline::runtime
