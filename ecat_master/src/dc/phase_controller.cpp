#include "driveline/ecat_master/dc/phase_controller.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driveline::ecat_master::dc {
namespace {

constexpr double kMinBandwidth = 0.01;  // rad per cycle
constexpr double kMaxBandwidth = 0.25;
constexpr double kNarrowestBandwidth = 0.001;
/// Whatever the noise: longest time to settle to 1 %, which takes kSettlingCycles / bandwidth cycles.
constexpr double kLongestSettlingNs = 1e9;
constexpr double kSettlingCycles = 7.0;
/// Largest standard deviation of the grid caused by measurement noise, as a share of the period.
constexpr double kGridNoise = 1.0 / 400.0;
/// (kp + 2 ki / kp) / 2 of the noise power reaches the grid.
constexpr double kNoisePower = 1.5;
/// A measurement is an outlier beyond this many mean deviations.
constexpr double kOutlierSpreads = 8.0;
/// After this many cycles at the frequency limit the cause is not noise.
constexpr std::uint32_t kLimitCycles = 100;
constexpr double kSpreadShare = 1.0 / 64.0;
/// The grid moves by at most this share of a period per cycle, so that the cycle time stays nearly constant.
constexpr double kMaxSlew = 1.0 / 200.0;

double or_share(PhaseController::Nanoseconds value, double period_ns, double share) noexcept {
  return value.count() > 0 ? static_cast<double>(value.count()) : period_ns * share;
}

}  // namespace

PhaseController::PhaseController(const Settings& settings) noexcept
    : settings_(settings),
      period_ns_(static_cast<double>(std::max<std::int64_t>(settings.period.count(), 1))),
      widest_(
          std::clamp(2.0 * std::numbers::pi * settings.bandwidth_hz * period_ns_ * 1e-9, kMinBandwidth, kMaxBandwidth)),
      narrowest_(std::min(widest_, std::max(kNarrowestBandwidth, kSettlingCycles * period_ns_ / kLongestSettlingNs))),
      outlier_floor_(or_share(settings.outlier_floor, period_ns_, 0.01)),
      lock_(LockDetector::Settings::for_period(settings.period)) {
  choose_gains();
}

void PhaseController::choose_gains() noexcept {
  const double noise = noise_ns();
  const double allowed = kGridNoise * period_ns_;
  const double quiet = allowed * allowed / (kNoisePower * std::max(noise * noise, 1.0));
  const double bandwidth = std::clamp(quiet, narrowest_, widest_);
  kp_ = 2.0 * bandwidth;
  ki_ = bandwidth * bandwidth;
}

void PhaseController::reset(double ppm) noexcept {
  *this = PhaseController(settings_);
  integral_ = std::clamp(ppm, -kMaxPpm, kMaxPpm) * 1e-6 * period_ns_;
}

PhaseController::Nanoseconds PhaseController::update(std::optional<Nanoseconds> error) noexcept {
  const bool measured = error && plausible(static_cast<double>(error->count()));
  double shift = -integral_;
  if (measured) {
    choose_gains();
    lock_.update(static_cast<double>(error->count()), noise_ns());
    shift = control(static_cast<double>(error->count()));
  } else {
    lock_.update(std::nullopt);
    ++coasted_;
  }
  return quantize(shift);
}

/// Updates the expectation of the next measurement.
bool PhaseController::plausible(double error) noexcept {
  const double deviation = std::abs(error - expected_);
  const double limit = std::max(outlier_floor_, kOutlierSpreads * spread_);
  const bool suspicious = primed_ && deviation > limit;
  // Limit deviations to the outlier threshold: one outlier hardly moves the threshold, and many outliers raise it until
  // it includes them.
  if (primed_) spread_ += kSpreadShare * (std::min(deviation, limit) - spread_);
  if (suspicious && ++suspicious_ <= settings_.outlier_limit) {
    ++outliers_;
    return false;
  }
  if (suspicious || !primed_) lock_.jump(error);
  suspicious_ = 0;
  primed_ = true;
  return true;
}

double PhaseController::control(double error) noexcept {
  const double slew = period_ns_ * kMaxSlew;
  const double limit = kMaxPpm * 1e-6 * period_ns_;
  const double proportional = kp_ * error;
  const double shift = -(std::clamp(proportional, -slew, slew) + integral_);
  expected_ = error + shift + integral_;
  // No integration while the output is limited, to avoid wind-up.
  if (std::abs(proportional) <= slew) integral_ += ki_ * error;
  at_limit_ = std::abs(integral_) >= limit ? at_limit_ + 1 : 0;
  // Slightly beyond the limit the proportional part still holds the phase, but the loop does not count as locked.
  if (at_limit_ >= kLimitCycles) lock_.lose(Cause::kFrequencyLimit);
  integral_ = std::clamp(integral_, -limit, limit);
  return shift;
}

PhaseController::Nanoseconds PhaseController::quantize(double shift) noexcept {
  const double wanted = shift + remainder_;
  const double whole = std::nearbyint(wanted);
  remainder_ = wanted - whole;
  return Nanoseconds{static_cast<std::int64_t>(whole)};
}

}  // namespace driveline::ecat_master::dc
