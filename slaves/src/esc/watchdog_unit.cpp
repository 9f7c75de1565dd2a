#include "driveline/slaves/esc/watchdog_unit.hpp"

#include <algorithm>

namespace driveline::slaves {

namespace reg = wire::reg;

void WatchdogUnit::reset() noexcept {
  expiry_ = kNever;
  expired_ = false;
  configure();
}

void WatchdogUnit::configure() noexcept {
  // The divider counts 25 MHz ticks and is written as its value minus 2 (ESC data sheet II, 0x0400).
  const auto unit = std::chrono::nanoseconds{40} * (std::int64_t{memory_.get(reg::kWatchdogDivider)} + 2);
  timeout_ = unit * std::int64_t{memory_.get(reg::kWatchdogTimeProcessData)};
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
  const auto count = memory_.get(reg::kWatchdogCounterProcessData);
  memory_.set(reg::kWatchdogCounterProcessData, static_cast<std::uint8_t>(std::min(count + 1, 0xFF)));
  events_.set_al(al_event::kWatchdogProcessData, true);
}

void WatchdogUnit::clear_counters() noexcept {
  memory_.set(reg::kWatchdogCounterProcessData, 0);
  memory_.set(reg::kWatchdogCounterPdi, 0);
}

}  // namespace driveline::slaves
