#include "driveline/slaves/msd/can/telegram_watch.hpp"

namespace driveline::slaves::msd {

void TelegramWatch::configure(Signal signal, std::chrono::milliseconds time_out) noexcept {
  signal_ = signal;
  time_out_ = time_out;
  restart(operational_);
}

void TelegramWatch::restart(bool operational) noexcept {
  operational_ = operational;
  deadline_ = can::kNever;
  lost_ = false;
}

void TelegramWatch::came(Signal signal, std::chrono::nanoseconds now) noexcept {
  if (!operational_ || signal != signal_ || time_out_.count() == 0) return;
  deadline_ = now + time_out_;
  lost_ = false;
}

bool TelegramWatch::fails(std::chrono::nanoseconds now) noexcept {
  if (deadline_ > now) return false;
  deadline_ = can::kNever;
  lost_ = true;
  return true;
}

}  // namespace driveline::slaves::msd
