#include "driveline/slaves/plant/dc_link.hpp"

#include <algorithm>
#include <cmath>

#include "in_range.hpp"

namespace driveline::slaves {
namespace {

constexpr double kHighestVolts = 1e4;

}  // namespace

DcLink::DcLink(const DcLinkParameters& parameters, double mains_volts) noexcept
    : volts_(in_range(mains_volts, 0.0, kHighestVolts, 0.0)), mains_volts_(volts_), parameters_(parameters) {
  parameters_.capacitance_f = at_least(parameters.capacitance_f, 1e-6);
  parameters_.brake_resistor_ohm = at_least(parameters.brake_resistor_ohm, 0.0);
  parameters_.standby_w = at_least(parameters.standby_w, 0.0);
}

void DcLink::set_mains(bool on) noexcept {
  mains_ = on;
  forced_ = false;
}

void DcLink::force(double volts) noexcept {
  volts_ = in_range(volts, 0.0, kHighestVolts, 0.0);
  forced_ = true;
}

void DcLink::step(double power_w, double step_s) noexcept {
  if (forced_) return;
  double taken_w = (std::isfinite(power_w) ? power_w : 0.0) + parameters_.standby_w;
  if (resistor_ && parameters_.brake_resistor_ohm > 0.0 && volts_ > parameters_.chopper_volts) {
    taken_w += volts_ * volts_ / parameters_.brake_resistor_ohm;
  }
  const double square = std::max(volts_ * volts_ - 2.0 * taken_w * step_s / parameters_.capacitance_f, 0.0);
  volts_ = std::sqrt(square);
  if (mains_) volts_ = std::max(volts_, mains_volts_);
}

}  // namespace driveline::slaves
