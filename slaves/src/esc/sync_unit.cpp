#include "driveline/slaves/esc/sync_unit.hpp"

#include <algorithm>

namespace driveline::slaves {

namespace reg = wire::reg;

namespace {

/// Bits of the activation status 0x0984.
constexpr std::uint8_t kSync0Pending = 0x01;
constexpr std::uint8_t kSync1Pending = 0x02;
constexpr std::uint8_t kImplausibleStart = 0x04;
/// Pulses whose interval is shorter than their length form a continuous signal (ESC data sheet I, cyclic generation);
/// this is the shortest pulse, in ns.
constexpr std::uint32_t kShortestPulse = 1000;
constexpr std::uint32_t kPulseLengthUnit = 10;
constexpr std::uint64_t k32 = std::uint64_t{1} << 32;

/// Whether `a` is earlier than `b`, across a wrap-around.
constexpr bool earlier(std::uint64_t a, std::uint64_t b) noexcept {
  return static_cast<std::int64_t>(a - b) < 0;
}

}  // namespace

void SyncUnit::reset() noexcept {
  activation_ = 0;
  stop();
}

void SyncUnit::stop() noexcept {
  next_ = {};
  started_ = sync1_ = false;
  set_status(kSync0Pending | kSync1Pending | kImplausibleStart, 0);
}

void SyncUnit::set_status(std::uint8_t clear, std::uint8_t set) noexcept {
  memory_.set(reg::kDcActivationStatus,
              static_cast<std::uint8_t>((memory_.get(reg::kDcActivationStatus) & ~unsigned{clear}) | set));
}

void SyncUnit::configure(std::uint64_t now) noexcept {
  const auto before = activation_;
  activation_ = memory_.get(reg::kDcActivation);
  const bool active = (activation_ & dc_activation::kUnit) != 0 && (activation_ & dc_activation::kSync0) != 0;
  if (!active) return stop();
  constexpr unsigned kSignals = dc_activation::kUnit | dc_activation::kSync0 | dc_activation::kSync1;
  // Writing the same signals again does not disturb the running pulses.
  if ((before & kSignals) == (activation_ & kSignals)) return;
  stop();
  cycle0_ = memory_.get(reg::kSync0CycleTime);
  cycle1_ = memory_.get(reg::kSync1CycleTime);
  const auto pulse = std::max(kShortestPulse, kPulseLengthUnit * memory_.get(reg::kSyncPulseLength));
  if (cycle0_ <= pulse) cycle0_ = 0;
  sync1_ = (activation_ & dc_activation::kSync1) != 0;
  next_[0] = first_pulse(now);
  set_status(0, static_cast<std::uint8_t>(kSync0Pending | (sync1_ ? kSync1Pending : 0U)));
}

std::optional<std::uint64_t> SyncUnit::first_pulse(std::uint64_t now) noexcept {
  const auto start = memory_.get(reg::kStartTimeCyclic);
  const std::uint64_t ahead = wide_ ? start - now : (start - now) % k32;
  if ((activation_ & dc_activation::kPlausibilityCheck) != 0) {
    const bool short_future = (activation_ & dc_activation::kNearFuture31) != 0;
    if (ahead >= (short_future ? std::uint64_t{1} << 31 : range())) {
      set_status(0, kImplausibleStart);
      return now + 1;
    }
  }
  if (wide_ && ahead >= range()) return std::nullopt;
  return now + ahead;
}

void SyncUnit::jumped(std::uint64_t before, std::uint64_t now) noexcept {
  skip_to(before);
  for (auto& next : next_) {
    if (!next || earlier(now, *next)) continue;
    // The time comparison no longer matches; with 32 bits, not until the clock has wrapped around.
    if (wide_) {
      next.reset();
    } else {
      *next += (now - *next + k32) / k32 * k32;
    }
  }
}

bool SyncUnit::sync0_is_next() const noexcept {
  return next_[0] && (!next_[1] || !earlier(*next_[1], *next_[0]));
}

std::optional<std::uint64_t> SyncUnit::next() const noexcept {
  return sync0_is_next() ? next_[0] : next_[1];
}

std::optional<SyncSignal> SyncUnit::fire() noexcept {
  if (sync0_is_next()) {
    const auto time = *next_[0];
    started_ = true;
    set_status(kSync0Pending, 0);
    if (cycle0_ == 0) {
      next_[0].reset();
    } else {
      next_[0] = time + cycle0_;
    }
    if (sync1_ && !next_[1]) next_[1] = time + cycle1_;
    return SyncSignal::kSync0;
  }
  if (!next_[1]) return std::nullopt;
  set_status(kSync1Pending, 0);
  next_[1].reset();
  return SyncSignal::kSync1;
}

void SyncUnit::skip_to(std::uint64_t time) noexcept {
  const auto due = [this, time] { return next() && earlier(*next(), time); };
  if (!due()) return;
  // Skip whole periods of both signals, so that their phase relation is preserved.
  const std::uint64_t period = cycle0_ == 0 ? 0 : (sync1_ ? cycle1_ / cycle0_ + 1U : 1U) * std::uint64_t{cycle0_};
  if (period != 0 && time - *next() > period) {
    const auto shift = (time - *next()) / period * period;
    for (auto& next : next_) {
      if (next) *next += shift;
    }
  }
  while (due()) {
    static_cast<void>(fire());
    leap_to(time);
  }
}

/// Skips pulses of SYNC0 without effect while SYNC1 is pending: there may be millions of them when the SYNC1 cycle is
/// that much longer.
void SyncUnit::leap_to(std::uint64_t time) noexcept {
  if (cycle0_ == 0 || !next_[0] || !next_[1]) return;
  const auto end = earlier(*next_[1], time) ? *next_[1] : time;
  if (earlier(*next_[0], end)) *next_[0] += (end - *next_[0]) / cycle0_ * cycle0_;
}

std::optional<std::uint64_t> SyncUnit::next_after(SyncSignal signal, std::uint64_t now) const noexcept {
  const auto& next = next_[signal == SyncSignal::kSync0 ? 0 : 1];
  if (signal == SyncSignal::kSync1 || !next || earlier(now, *next) || cycle0_ == 0) return next;
  return *next + ((now - *next) / cycle0_ + 1) * cycle0_;
}

}  // namespace driveline::slaves
