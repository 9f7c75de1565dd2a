#include "driveline/slaves/msd/core/sercos/sercos_scale.hpp"

#include <numbers>

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {

SercosScale SercosScale::preferred(std::uint32_t encoder_increments) noexcept {
  constexpr std::uint32_t kUnitsPerTurn = 3'600'000;
  SercosScale scale;
  scale.scaling.position_rad = 2.0 * std::numbers::pi / kUnitsPerTurn;
  scale.scaling.velocity_rad_s = 1e-4 * kRpm;
  scale.scaling.acceleration_rad_s2 = 1e-3;
  scale.scaling.units_per_increment = Ratio::of(kUnitsPerTurn, encoder_increments);
  scale.scaling.increments_per_unit = scale.scaling.units_per_increment.inverse();
  return scale;
}

}  // namespace driveline::slaves::msd
