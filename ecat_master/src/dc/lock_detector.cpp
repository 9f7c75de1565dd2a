#include "driveline/ecat_master/dc/lock_detector.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::ecat_master::dc {
namespace {

constexpr double kMeanShare = 1.0 / 16.0;
constexpr double kLeastMeanShare = 1.0 / 1024.0;
constexpr double kUnlockFactor = 4.0;

/// Share of a measurement in the mean. Independent measurements of deviation s, each contributing this share, give a
/// mean of deviation s * sqrt(share / 2).
double mean_share(double noise_ns, double window_ns) noexcept {
  const double wanted = window_ns / 4.0;
  return std::clamp(2.0 * wanted * wanted / std::max(noise_ns * noise_ns, 1.0), kLeastMeanShare, kMeanShare);
}

}  // namespace

LockDetector::Settings LockDetector::Settings::for_period(std::chrono::nanoseconds period) noexcept {
  constexpr std::chrono::nanoseconds kLockTime = std::chrono::milliseconds{100};
  const auto cycles = static_cast<std::uint32_t>(
      std::clamp<std::int64_t>(kLockTime / std::max(period, std::chrono::nanoseconds{1}), 20, 200));
  return {static_cast<double>(period.count()) * 0.01, cycles, cycles / 4, cycles * 2};
}

void LockDetector::update(std::optional<double> error_ns, double noise_ns) noexcept {
  if (!error_ns) {
    if (++missing_ >= settings_.coast_cycles) lose(LockCause::kNoReference);
    return;
  }
  missing_ = 0;
  mean_error_ += mean_share(noise_ns, settings_.window_ns) * (*error_ns - mean_error_);
  const double error = std::abs(mean_error_);
  inside_ = error <= settings_.window_ns ? inside_ + 1 : 0;
  outside_ = error > kUnlockFactor * settings_.window_ns ? outside_ + 1 : 0;
  if (outside_ >= settings_.unlock_cycles) return lose(LockCause::kPhaseError);
  if (inside_ >= settings_.lock_cycles) cause_ = LockCause::kNone;
}

void LockDetector::lose(LockCause cause) noexcept {
  inside_ = 0;
  // A phase error adds no information while acquiring; a missing reference or the frequency limit does.
  if (cause_ == LockCause::kAcquiring && cause == LockCause::kPhaseError) return;
  cause_ = cause;
}

}  // namespace driveline::ecat_master::dc
