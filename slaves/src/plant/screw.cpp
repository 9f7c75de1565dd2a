#include "driveline/slaves/plant/screw.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driveline::slaves {

Screw::Screw(const ScrewParameters& parameters, double shaft_rad) noexcept
    : parameters_(parameters), nut_rad_(shaft_rad) {}

void Screw::turn(double shaft_rad) noexcept {
  nut_rad_ = std::clamp(nut_rad_, shaft_rad, shaft_rad + parameters_.backlash_rad);
}

double Screw::position_of(double shaft_rad) const noexcept {
  const double phase = 2.0 * std::numbers::pi * shaft_rad / parameters_.wave_length_rad;
  return shaft_rad + parameters_.stretch * shaft_rad + parameters_.wave_rad * std::sin(phase);
}

}  // namespace driveline::slaves
