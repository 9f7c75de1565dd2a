#include "driveline/slaves/plant/thermal_model.hpp"

#include <algorithm>
#include <cmath>

#include "in_range.hpp"

namespace driveline::slaves {
namespace {

constexpr double kOverloadFactor = 1.5;  ///< FREQ: multiple of the permitted current that trips after kOverloadTimeS
constexpr double kOverloadTimeS = 120.0;

double permitted(double frequency_hz, const OverloadLimits& limits) noexcept {
  const double f = std::abs(frequency_hz);
  const auto between = [](double x, double x0, double y0, double x1, double y1) {
    return x1 > x0 ? y0 + (y1 - y0) * (x - x0) / (x1 - x0) : y1;
  };
  double current = limits.rated;
  if (f < limits.middle_hz) {
    current = between(f, 0.0, limits.standstill, limits.middle_hz, limits.middle);
  } else if (f < limits.rated_hz) {
    current = between(f, limits.middle_hz, limits.middle, limits.rated_hz, limits.rated);
  }
  return at_least(current, 0.01);
}

}  // namespace

ThermalModel::ThermalModel(const ThermalParameters& parameters) noexcept : parameters_(parameters) {
  const ThermalParameters standard;
  parameters_.motor_time_constant_s = at_least(parameters.motor_time_constant_s, 1e-3);
  parameters_.amplifier_time_constant_s = at_least(parameters.amplifier_time_constant_s, 1e-3);
  parameters_.motor_rise_k = at_least(parameters.motor_rise_k, 0.0);
  parameters_.amplifier_rise_k = at_least(parameters.amplifier_rise_k, 0.0);
  if (!std::isfinite(parameters.ambient_c)) parameters_.ambient_c = standard.ambient_c;
  motor_c_ = amplifier_c_ = parameters_.ambient_c;
}

void ThermalModel::reset() noexcept {
  *this = ThermalModel(parameters_);
}

void ThermalModel::set_ambient(double celsius) noexcept {
  if (std::isfinite(celsius)) parameters_.ambient_c = celsius;
}

void ThermalModel::step(double current, double frequency_hz, const OverloadLimits& limits, double step_s) noexcept {
  const double square = std::isfinite(current) ? std::min(current * current, 1e6) : 0.0;
  const auto lag = [&](double& state, double target, double time_constant_s) {
    state += std::min(step_s / time_constant_s, 1.0) * (target - state);
  };
  lag(motor_c_, parameters_.ambient_c + parameters_.motor_rise_k * square, parameters_.motor_time_constant_s);
  lag(amplifier_c_, parameters_.ambient_c + parameters_.amplifier_rise_k * square,
      parameters_.amplifier_time_constant_s);
  const double share = at_least(limits.rated_share, 1e-6);
  const double counted = square / (share * share);
  if (limits.thermal) return lag(overload_percent_, 100.0 * counted, at_least(limits.time_constant_s, 1e-3));
  const double allowed = permitted(frequency_hz, limits);
  const double full = (kOverloadFactor * kOverloadFactor - 1.0) * kOverloadTimeS;
  overload_percent_ += 100.0 * step_s * (counted / (allowed * allowed) - 1.0) / full;
  overload_percent_ = std::max(overload_percent_, 0.0);
}

}  // namespace driveline::slaves
