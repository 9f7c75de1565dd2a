#include "devices/msd/msd_rules.hpp"

#include <bit>

namespace driveline::runtime {
namespace {

using ecat_master::startup_sdo;

/// Objects of manufacturer parameters: 2000h plus the parameter's number (MSD manual 8.2.3).
constexpr std::uint16_t parameter(unsigned number) {
  return static_cast<std::uint16_t>(0x2000 + number);
}

ecat_master::StartupSdo real_sdo(std::uint16_t index, double value) {
  return startup_sdo(index, 0, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

}  // namespace

std::vector<ecat_master::StartupSdo> MsdRules::startup_sdos(const ecat_master::AxisConfig& axis,
                                                            std::chrono::nanoseconds period) const {
  auto sdos = ecat_master::cia402_startup_sdos(period);
  sdos.insert(sdos.begin(), real_sdo(parameter(306), std::chrono::duration<double, std::milli>(period).count()));
  // Also where the axis begins in another mode: it may change to csp.
  constexpr std::uint8_t kCubicSpline = 3;
  sdos.push_back(startup_sdo(parameter(370), 0, kCubicSpline));
  if (axis.inertia > 0.0 && !axis.linear()) sdos.push_back(real_sdo(parameter(1516), axis.inertia));
  return sdos;
}

}  // namespace driveline::runtime
