#include "driveline/slaves/can/error_counters.hpp"

#include <algorithm>

namespace driveline::slaves::can {

ErrorState ErrorCounters::state() const noexcept {
  if (transmit_ >= kBusOff) return ErrorState::kBusOff;
  return std::max(transmit_, receive_) >= kPassive ? ErrorState::kPassive : ErrorState::kActive;
}

void ErrorCounters::receive_error(unsigned amount) noexcept {
  receive_ = std::min(receive_ + amount, 255U);  // ISO 11898-1: the counter needs no more than eight bits
}

void ErrorCounters::received() noexcept {
  if (receive_ >= kPassive) {
    receive_ = kPassive - 1;
  } else if (receive_ > 0) {
    --receive_;
  }
}

}  // namespace driveline::slaves::can
