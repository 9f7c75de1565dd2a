#include "driveline/slaves/plant/voltage_frequency.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driveline::slaves {
namespace {

constexpr double kTakeOverS = 0.04;       ///< several time constants of a winding
constexpr double kDampingRadS = 46.0;     ///< electrical, per rated current; tested with 1/3 to 10 times the inertia
constexpr double kDampingCornerS = 0.05;  ///< slower changes of the active current are due to load
constexpr double kDampedFrom = 60.0 * std::numbers::pi;  ///< electrical rad/s; below, the resistance damps enough
constexpr double kLimitGain = 0.3;                       ///< share of the voltage removed per step and excess
constexpr double kRecoveryS = 0.05;                      ///< until the whole voltage is restored
constexpr double kSmallestShare = 0.05;

}  // namespace

double VoltageFrequency::characteristic_v(double electrical_rad_s) const noexcept {
  const double nominal = 2.0 * std::numbers::pi * std::max(parameters_.nominal_hz, 1e-3);
  const double share = std::min(std::abs(electrical_rad_s) / nominal, 1.0);
  return parameters_.boost_v + (parameters_.nominal_v - parameters_.boost_v) * share;
}

void VoltageFrequency::start(const VoltageVector& in_force, double angle_rad, double electrical_rad_s) noexcept {
  angle_rad_ = angle_rad;
  share_ = 1.0;
  const double turn = in_force.angle_rad - angle_rad;
  start_in_phase_v_ = in_force.in_phase_v * std::cos(turn) - in_force.quadrature_v * std::sin(turn) -
                      characteristic_v(electrical_rad_s);
  start_quadrature_v_ = in_force.in_phase_v * std::sin(turn) + in_force.quadrature_v * std::cos(turn);
  start_left_ = 1.0;
}

void VoltageFrequency::limit_current(double amplitude_a) noexcept {
  const double excess = amplitude_a / std::max(parameters_.max_current_a, 1e-6) - 1.0;
  share_ = excess > 0.0 ? std::max(share_ - kLimitGain * excess, kSmallestShare)
                        : std::min(share_ + step_s_ / kRecoveryS, 1.0);
}

VoltageVector VoltageFrequency::step(double electrical_rad_s, const PhaseCurrents& currents) noexcept {
  limit_current(currents.amplitude_a);
  const double amplitude = characteristic_v(electrical_rad_s) * share_;
  const VoltageVector voltage{amplitude + start_left_ * start_in_phase_v_, start_left_ * start_quadrature_v_,
                              angle_rad_};
  // While the vector changes over from the initial one, its active current changes with it; no damping then.
  const double follow = start_left_ > 0.0 ? 1.0 : step_s_ / kDampingCornerS;
  mean_active_a_ += follow * (currents.active_a - mean_active_a_);
  const double swing = (currents.active_a - mean_active_a_) / std::max(parameters_.rated_current_a, 1e-6);
  const double damping = kDampingRadS * std::clamp(electrical_rad_s / kDampedFrom, -1.0, 1.0);
  start_left_ = std::max(start_left_ - step_s_ / kTakeOverS, 0.0);
  angle_rad_ += step_s_ * (electrical_rad_s - damping * swing);
  return voltage;
}

}  // namespace driveline::slaves
