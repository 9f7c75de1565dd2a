#include "driveline/slaves/esc/time_loop.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::slaves {

namespace {

/// Share of a difference that is corrected per nanosecond, and at least per reference time, at speed counter start
/// 0x1000. The second value applies in the static phase of a master, which sends thousands of reference times back to
/// back, many in a frame.
constexpr double kProportional = 40e-9;
constexpr double kShare = 0.005;
constexpr double kMaxShare = 0.25;
/// A proportional correction ends after kHold and kHoldPeriods periods, so that rare reference times do not overshoot.
constexpr std::int64_t kHold = 10'000'000;
constexpr std::int64_t kHoldPeriods = 4;
/// Differences beyond these limits, absolute and per nanosecond since the last reference time, are not drift: a clock
/// has been set. They are corrected at maximum speed, without changing the integral.
constexpr double kOffset = 3000.0;
constexpr double kOffsetShare = 2e-3;
/// The counter difference stays at least this far below the counter start (ESC data sheet II, 0x0932).
constexpr int kCounterMargin = 0x7F;
constexpr int kMinStart = 0x80;
constexpr int kDefaultDepth = 12;
/// Iterations of the inversion: the rate error is below 1e-3, and each multiplies the error by it: enough for kReach.
constexpr int kInverseRounds = 8;

double rate_of(int counter, int start) noexcept {
  return static_cast<double>(counter) /
         (5.0 * static_cast<double>(start + counter + 2) * static_cast<double>(start - counter + 2));
}

}  // namespace

void TimeLoop::reset(std::int64_t start) noexcept {
  *this = TimeLoop{};
  anchor_local_ = static_cast<std::uint64_t>(start);
}

double TimeLoop::gained(std::int64_t distance) const noexcept {
  const auto held = std::min(distance, hold_);
  return anchor_fraction_ + static_cast<double>(held) * rate_ + static_cast<double>(distance - held) * settled_rate_;
}

std::uint64_t TimeLoop::local(std::int64_t count) const noexcept {
  const auto distance = count - anchor_count_;
  return anchor_local_ + static_cast<std::uint64_t>(distance + static_cast<std::int64_t>(std::floor(gained(distance))));
}

std::optional<std::int64_t> TimeLoop::count_of(std::uint64_t local_time) const noexcept {
  const auto distance = static_cast<std::int64_t>(local_time - anchor_local_);
  if (distance > kReach || distance < -kReach) return std::nullopt;
  const auto missing = [&](std::int64_t count) { return static_cast<std::int64_t>(local_time - local(count)); };
  auto count = anchor_count_ + distance;
  for (int round = 0; round < kInverseRounds && missing(count) != 0; ++round) count += missing(count);
  while (missing(count) > 0) ++count;
  while (missing(count - 1) <= 0) --count;
  return count;
}

void TimeLoop::anchor(std::int64_t count) noexcept {
  const auto distance = count - anchor_count_;
  const double sum = gained(distance);
  const double whole = std::floor(sum);
  anchor_local_ += static_cast<std::uint64_t>(distance + static_cast<std::int64_t>(whole));
  anchor_fraction_ = sum - whole;
  anchor_count_ = count;
}

TimeLoop::Speed TimeLoop::quantised(double rate, const Settings& settings) noexcept {
  const int start = std::max<int>(settings.speed_counter_start, kMinStart);
  // The counter for this rate: positive root of 5 r D^2 + D - 5 r (S + 2)^2 = 0, with the sign of r.
  const double reach = static_cast<double>(start + 2);
  const double exact = rate == 0.0 ? 0.0 : (std::sqrt(1.0 + 100.0 * rate * rate * reach * reach) - 1.0) / (10.0 * rate);
  const double limit = start - kCounterMargin;
  const int counter = static_cast<int>(std::lround(std::clamp(exact, -limit, limit)));
  return {rate_of(counter, start), counter};
}

void TimeLoop::follow(std::int64_t difference, std::int64_t count, const Settings& settings) noexcept {
  anchor(count);
  if (last_ != count) {
    period_ = std::max<std::int64_t>(count - last_.value_or(count), 0);
    last_ = count;
    repeats_ = 0;
    settled_integral_ = integral_;
  }
  // Several reference times in a frame have the same difference: their shares add up.
  ++repeats_;
  const auto elapsed = period_;
  const int start = std::max<int>(settings.speed_counter_start, kMinStart);
  const double limit = rate_of(start - kCounterMargin, start);
  const double share = std::min(kShare * repeats_, kMaxShare);
  const double per_time = elapsed > 0 ? share / static_cast<double>(elapsed) : 0.0;
  const double bandwidth = std::max(kProportional, per_time) * 0x1000 / start;
  const double slower = std::ldexp(1.0, std::clamp(kDefaultDepth - settings.filter_depth, -4, 1));
  const auto error = static_cast<double>(difference);
  const bool offset = std::abs(error) > std::max(kOffset, kOffsetShare * static_cast<double>(elapsed));
  const double wanted = offset ? std::copysign(limit, -error) : settled_integral_ - bandwidth * error;
  // A difference that cannot be corrected in time must not wind up the integral, unless it is drift between rare
  // reference times.
  const bool saturated = std::abs(wanted) > limit && elapsed < kHold;
  if (!offset && !saturated) {
    // Rare reference times are weighted less than their interval, else they would overshoot.
    const auto e = static_cast<double>(std::min(elapsed, kHold));
    const double weight = elapsed > kHold ? static_cast<double>(kHold) / static_cast<double>(elapsed) : 1.0;
    const double step = bandwidth * bandwidth / 4.0 * slower * error * e * weight;
    integral_ = std::clamp(settled_integral_ - step, -limit, limit);
  }
  const auto settled = quantised(integral_, settings);
  rate_ = quantised(offset ? wanted : integral_ - bandwidth * error, settings).rate;
  settled_rate_ = settled.rate;
  difference_ = static_cast<std::int16_t>(settled.counter);
  hold_ = elapsed > 0 ? std::min(kHold, kHoldPeriods * elapsed) : kHold;
}

void TimeLoop::restart(std::int64_t count) noexcept {
  anchor(count);
  rate_ = settled_rate_ = integral_ = 0.0;
  difference_ = 0;
  last_.reset();
}

}  // namespace driveline::slaves
