#include "driveline/slaves/can/error_counters.hpp"

#include <algorithm>

namespace driveline::slaves::can {

void ErrorCounters::receive_error(unsigned amount) noexcept {
  receive_ = std::min(receive_ + amount, 255U);  // ISO 11898-1: the counter needs no more than eight bits
}

}  // namespace driveline::slaves::can
