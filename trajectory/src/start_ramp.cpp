#include "driveline/trajectory/start_ramp.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

// Largest first and second derivative of 10 x^3 - 15 x^4 + 6 x^5 on [0, 1], at 1/2 and at 1/2 -+ sqrt(3)/6.
constexpr double kPeakVelocity = 15.0 / 8.0;
constexpr double kPeakAcceleration = 5.773502691896258;  // 10 / sqrt(3)

}  // namespace

std::optional<StartRamp> StartRamp::plan(double from, double to, const AxisLimits& limits) noexcept {
  if (!(limits.max_velocity > 0.0) || !(limits.max_acceleration > 0.0) || !std::isfinite(limits.max_velocity) ||
      !std::isfinite(limits.max_acceleration)) {
    return std::nullopt;
  }
  const double distance = std::abs(to - from);
  const double duration_s = std::max(kPeakVelocity * distance / limits.max_velocity,
                                     std::sqrt(kPeakAcceleration * distance / limits.max_acceleration));
  if (!std::isfinite(duration_s)) {
    return std::nullopt;
  }
  return StartRamp(from, to, duration_s);
}

void StartRamp::stretch_to(double duration_s) noexcept {
  if (duration_s > duration_s_ && std::isfinite(duration_s)) {
    duration_s_ = duration_s;
  }
}

AxisSetpoint StartRamp::evaluate(double elapsed_s) const noexcept {
  if (finished(elapsed_s)) {
    return {to_, 0.0, 0.0};
  }
  if (!(elapsed_s > 0.0)) {
    return {from_, 0.0, 0.0};
  }
  const double x = elapsed_s / duration_s_;
  const double rest = 1.0 - x;
  const double velocity = (to_ - from_) / duration_s_;
  return {from_ + (to_ - from_) * (x * x * x * (10.0 + x * (6.0 * x - 15.0))), velocity * 30.0 * x * x * rest * rest,
          velocity / duration_s_ * 60.0 * x * rest * (1.0 - 2.0 * x)};
}

}  // namespace driveline::trajectory
