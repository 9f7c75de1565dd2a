#include "driveline/motion/axis/startup_sdos.hpp"

#include <stdexcept>

namespace driveline::motion {

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
  std::vector<StartupSdo> sdos{startup_sdo(kInterpolationTime, 1, interpolation->value),
                               startup_sdo(kInterpolationTime, 2, interpolation->exponent)};
  for (auto& sdo : sdos) sdo.need = WriteNeed::kOptional;
  return sdos;
}

StartupSdo mode_sdo(cia402::Mode mode) {
  return startup_sdo(0x6060, 0, static_cast<std::int8_t>(mode));
}

}  // namespace driveline::motion
