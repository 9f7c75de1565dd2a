#include "driveline/trajectory/coupling_law.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

/// Number of samples of a run-in: its extremes are broad.
constexpr int kRunInSamples = 64;

}  // namespace

CouplingLaw CouplingLaw::gear(const GearRatio& ratio, double master, double slave) noexcept {
  CouplingLaw law;
  law.ratio_ = ratio;
  law.master_ = master;
  law.slave_ = slave;
  return law;
}

CouplingLaw CouplingLaw::cam(const Cam& cam, double master, double slave) noexcept {
  CouplingLaw law;
  law.cam_ = &cam;
  law.master_ = master;
  law.slave_ = slave;
  return law;
}

Cam::Value CouplingLaw::at(double master) const noexcept {
  if (cam_ == nullptr) return {slave_ + ratio_.travel(master - master_), ratio_.factor(), 0.0};
  auto value = cam_->evaluate(master - master_);
  value.position += slave_;
  return value;
}

RunIn::RunIn(double rest, double sync, double distance, const Cam::Value& end) noexcept
    : begin_(sync - distance), distance_(distance), rest_(rest) {
  const double way = end.position - rest;
  const double slope = end.slope * distance;
  const double curvature = end.curvature * distance * distance;
  powers_ = {10.0 * way - 4.0 * slope + 0.5 * curvature, -15.0 * way + 7.0 * slope - curvature,
             6.0 * way - 3.0 * slope + 0.5 * curvature};
}

Cam::Value RunIn::at(double master) const noexcept {
  const double z = std::clamp(part(master), 0.0, 1.0);
  const auto& [c3, c4, c5] = powers_;
  return {rest_ + ((c5 * z + c4) * z + c3) * z * z * z, ((5.0 * c5 * z + 4.0 * c4) * z + 3.0 * c3) * z * z / distance_,
          ((20.0 * c5 * z + 12.0 * c4) * z + 6.0 * c3) * z / (distance_ * distance_)};
}

RunIn::Demand RunIn::demand(double velocity) const noexcept {
  const double rate = std::abs(velocity / distance_);
  const auto& [c3, c4, c5] = powers_;
  Demand most;
  for (int i = 0; i <= kRunInSamples; ++i) {
    const double z = static_cast<double>(i) / kRunInSamples;
    const double slope = ((5.0 * c5 * z + 4.0 * c4) * z + 3.0 * c3) * z * z;
    const double curvature = ((20.0 * c5 * z + 12.0 * c4) * z + 6.0 * c3) * z;
    const double third = (60.0 * c5 * z + 24.0 * c4) * z + 6.0 * c3;
    most.velocity = std::max(most.velocity, std::abs(slope) * rate);
    most.acceleration = std::max(most.acceleration, std::abs(curvature) * rate * rate);
    most.jerk = std::max(most.jerk, std::abs(third) * rate * rate * rate);
  }
  return most;
}

AxisSetpoint along(const Cam::Value& value, const AxisSetpoint& master) noexcept {
  return {value.position, value.slope * master.velocity,
          value.curvature * master.velocity * master.velocity + value.slope * master.acceleration};
}

}  // namespace driveline::trajectory
