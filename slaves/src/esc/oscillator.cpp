#include "driveline/slaves/esc/oscillator.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/slaves/esc/random_source.hpp"

namespace driveline::slaves {

namespace {

/// Triangle wave of period 1 and amplitude 1, rising through zero at phase 0.
double triangle(double phase) noexcept {
  const double p = phase - std::floor(phase);
  return p < 0.25 ? 4.0 * p : p < 0.75 ? 2.0 - 4.0 * p : 4.0 * p - 4.0;
}

/// Integral of triangle() from phase 0; also periodic.
double triangle_integral(double phase) noexcept {
  const double p = phase - std::floor(phase);
  if (p < 0.25) return 2.0 * p * p;
  return p < 0.75 ? 2.0 * p - 2.0 * p * p - 0.25 : 2.0 * (1.0 - p) * (1.0 - p);
}

/// Iterations of the inversion: each multiplies the error by the relative rate error, which is enough for kReach.
constexpr int kTimeOfRounds = 8;

}  // namespace

Oscillator::Oscillator(const ClockOptions& options) noexcept
    : period_(std::max<std::int64_t>(options.resolution.count(), 1)),
      drift_(options.drift_ppm * 1e-6),
      span_(std::abs(options.temperature_span_ppm) * 1e-6) {
  const double slope_per_ns = std::abs(options.temperature_ppm_per_s) * 1e-6 * 1e-9;
  if (slope_per_ns > 0.0 && span_ > 0.0) wander_period_ = 4.0 * span_ / slope_per_ns;
  wander_phase_ = RandomSource(options.seed).uniform();
}

double Oscillator::wander_ns(double elapsed) const noexcept {
  if (!(wander_period_ > 0.0)) return 0.0;
  const double phase = wander_phase_ + elapsed / wander_period_;
  return span_ * wander_period_ * (triangle_integral(phase) - triangle_integral(wander_phase_));
}

std::int64_t Oscillator::elapsed_count(std::int64_t elapsed) const noexcept {
  // The error is computed separately from the time: a single double would lose nanoseconds after some weeks.
  const auto e = static_cast<double>(elapsed);
  return elapsed + static_cast<std::int64_t>(std::floor(e * drift_ + wander_ns(e)));
}

std::int64_t Oscillator::count(Nanoseconds now) const noexcept {
  const auto exact = elapsed_count((now - origin_).count());
  const auto rest = exact % period_;
  return exact - (rest < 0 ? rest + period_ : rest);
}

Oscillator::Nanoseconds Oscillator::time_of(std::int64_t count) const noexcept {
  const auto near = std::clamp(count, -kReach, kReach);
  const auto rest = near % period_;
  const auto step = rest == 0 ? near : near - rest + (rest > 0 ? period_ : 0);
  auto elapsed = step;
  for (int round = 0; round < kTimeOfRounds && elapsed_count(elapsed) != step; ++round)
    elapsed += step - elapsed_count(elapsed);
  while (elapsed_count(elapsed) < step) ++elapsed;
  while (elapsed_count(elapsed - 1) >= step) --elapsed;
  return origin_ + Nanoseconds{elapsed};
}

double Oscillator::rate_error_ppm(Nanoseconds now) const noexcept {
  const auto elapsed = static_cast<double>((now - origin_).count());
  const double wander = wander_period_ > 0.0 ? span_ * triangle(wander_phase_ + elapsed / wander_period_) : 0.0;
  return (drift_ + wander) * 1e6;
}

}  // namespace driveline::slaves
