#include "driveline/slaves/esc/watchdog_unit.hpp"

#include <algorithm>

namespace driveline::slaves {

namespace reg = wire::reg;

void WatchdogUnit::reset() noexcept {
  expiry_ = kNever;
  expired_ = false;
  pdi_alive();
  configure();
}

std::chrono::nanoseconds WatchdogUnit::unit() const noexcept {
  // The divider counts 25 MHz ticks; the register contains its value minus 2 (ESC data sheet II, 0x0400).
  return std::chrono::nanoseconds{40} * (std::int64_t{memory_.get(reg::kWatchdogDivider)} + 2);
}

void WatchdogUnit::configure() noexcept {
  timeout_ = unit() * std::int64_t{memory_.get(reg::kWatchdogTimeProcessData)};
  if (!enabled()) {
    expiry_ = kNever;
    expired_ = false;
    set_status(true);
    return;
  }
  if (expiry_ != kNever) expiry_ = last_trigger_ + timeout_;
  set_status(expiry_ != kNever);
}

void WatchdogUnit::trigger(std::chrono::nanoseconds now) noexcept {
  if (!enabled()) return;
  last_trigger_ = now;
  expiry_ = now + timeout_;
  if (expired_ || memory_.get(reg::kWatchdogStatusProcessData) == 0) {
    expired_ = false;
    set_status(true);
    events_.set_al(al_event::kWatchdogProcessData, false);
  }
}

void WatchdogUnit::expire() noexcept {
  expiry_ = kNever;
  expired_ = true;
  set_status(false);
  count(reg::kWatchdogCounterProcessData);
  events_.set_al(al_event::kWatchdogProcessData, true);
}

void WatchdogUnit::count(const reg::U8& counter) noexcept {
  memory_.set(counter, static_cast<std::uint8_t>(std::min(memory_.get(counter) + 1, 0xFF)));
}

void WatchdogUnit::pdi_silent(std::chrono::nanoseconds since) noexcept {
  const auto timeout = unit() * std::int64_t{memory_.get(reg::kWatchdogTimePdi)};
  pdi_expiry_ = timeout > std::chrono::nanoseconds::zero() ? since + timeout : kNever;
}

void WatchdogUnit::pdi_alive() noexcept {
  pdi_expiry_ = kNever;
  pdi_expired_ = false;
}

void WatchdogUnit::expire_pdi() noexcept {
  pdi_expiry_ = kNever;
  pdi_expired_ = true;
  count(reg::kWatchdogCounterPdi);
}

void WatchdogUnit::clear_counters() noexcept {
  memory_.set(reg::kWatchdogCounterProcessData, 0);
  memory_.set(reg::kWatchdogCounterPdi, 0);
}

}  // namespace driveline::slaves
