#include "driveline/ecat_master/axis/startup_sdos.hpp"

#include <bit>
#include <stdexcept>

namespace driveline::ecat_master {
namespace {

/// Objects of manufacturer parameters: 2000h plus the parameter's number (MSD manual 8.2.3).
constexpr std::uint16_t parameter(unsigned number) {
  return static_cast<std::uint16_t>(0x2000 + number);
}

template <typename T>
StartupSdo sdo(std::uint16_t index, std::uint8_t subindex, T value) {
  const auto bytes = wire::to_le_bytes(value);
  return {index, subindex, {bytes.begin(), bytes.end()}};
}

StartupSdo real_sdo(std::uint16_t index, double value) {
  return sdo(index, 0, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

}  // namespace

std::optional<InterpolationPeriod> to_interpolation_period(std::chrono::nanoseconds period) noexcept {
  std::int64_t value = period.count();
  int exponent = -9;
  while (value != 0 && value % 10 == 0 && exponent < 0) {
    value /= 10;
    ++exponent;
  }
  if (value < 1 || value > 255) return std::nullopt;
  return InterpolationPeriod{static_cast<std::uint8_t>(value), static_cast<std::int8_t>(exponent)};
}

std::vector<StartupSdo> cia402_startup_sdos(std::chrono::nanoseconds period) {
  const auto interpolation = to_interpolation_period(period);
  if (!interpolation) throw std::invalid_argument("the cycle time has too many digits for object 60C2h");
  return {sdo(0x60C2, 1, interpolation->value), sdo(0x60C2, 2, interpolation->exponent)};
}

StartupSdo mode_sdo(cia402::Mode mode) {
  return sdo(0x6060, 0, static_cast<std::int8_t>(mode));
}

std::vector<StartupSdo> msd_startup_sdos(const AxisConfig& axis, std::chrono::nanoseconds period) {
  auto sdos = cia402_startup_sdos(period);
  sdos.insert(sdos.begin(), real_sdo(parameter(306), std::chrono::duration<double, std::milli>(period).count()));
  if (axis.mode == cia402::Mode::kCyclicPosition) {
    constexpr std::uint8_t kCubicSpline = 3;
    sdos.push_back(sdo(parameter(370), 0, kCubicSpline));
    if (axis.inertia > 0.0 && !axis.linear()) sdos.push_back(real_sdo(parameter(1516), axis.inertia));
  }
  return sdos;
}

}  // namespace driveline::ecat_master
