#include "driveline/motion/axis/setpoint_delay.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::motion {
namespace {

/// Mean delay added by a drive that is synchronised by SYNC0: its control step does not start at SYNC0, and its
/// measured values wait for the exchange (MSD: control steps of 62.5 us).
constexpr std::chrono::nanoseconds kControlDelay{62'500};

}  // namespace

double setpoint_delay_cycles(const SetpointDelays& delays) noexcept {
  // A setpoint is sent at the start of the next cycle.
  double cycles = 1.0 + static_cast<double>(delays.interpolation) * delays.divider;
  if (delays.to_sync0) {
    using Fractional = std::chrono::duration<double, std::nano>;
    cycles += Fractional(*delays.to_sync0 + kControlDelay) / Fractional(delays.period);
  }
  return cycles;
}

double can_setpoint_delay_cycles(std::chrono::nanoseconds period, unsigned interpolation) noexcept {
  return setpoint_delay_cycles({period, 1, interpolation, period});
}

SetpointHistory::SetpointHistory(double delay_cycles)
    : positions_(static_cast<std::size_t>(std::max(delay_cycles, 0.0)) + 2),
      whole_(positions_.size() - 2),
      part_(std::max(delay_cycles, 0.0) - std::floor(std::max(delay_cycles, 0.0))) {}

void SetpointHistory::push(double position) noexcept {
  newest_ = newest_ + 1 == positions_.size() ? 0 : newest_ + 1;
  positions_[newest_] = position;
  filled_ = std::min(filled_ + 1, positions_.size());
}

void SetpointHistory::extrapolate(std::int64_t cycles, double step) noexcept {
  if (cycles <= 0) return;
  // Older ones than the history holds would be overwritten.
  const auto kept = std::min(cycles, static_cast<std::int64_t>(positions_.size()));
  double position = ago(0) + static_cast<double>(cycles - kept) * step;
  for (std::int64_t cycle = 0; cycle < kept; ++cycle) push(position += step);
}

double SetpointHistory::ago(std::size_t cycles) const noexcept {
  const auto age = std::min(cycles, std::max<std::size_t>(filled_, 1) - 1);
  return positions_[newest_ >= age ? newest_ - age : newest_ + positions_.size() - age];
}

double SetpointHistory::continued(double later_cycles) const noexcept {
  return ago(0) + later_cycles * (ago(0) - ago(1));
}

double SetpointHistory::followed_later(double later_cycles) const noexcept {
  const double age = static_cast<double>(whole_) + part_ - later_cycles;
  if (age <= 0.0) return continued(-age);
  const double whole = std::floor(age);
  const double later = ago(static_cast<std::size_t>(whole));
  return later + (age - whole) * (ago(static_cast<std::size_t>(whole) + 1) - later);
}

double SetpointHistory::followed() const noexcept {
  const double later = ago(whole_);
  return later + part_ * (ago(whole_ + 1) - later);
}

}  // namespace driveline::motion
