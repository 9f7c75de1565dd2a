#include "driveline/slaves/can/bus_off_recovery.hpp"

#include <algorithm>

namespace driveline::slaves::can {

void BusOffRecovery::start(nanoseconds now) noexcept {
  left_ = kSequences;
  started_ = now;
}

/// Counts the sequences of the recessive wire that ends now.
void BusOffRecovery::count(nanoseconds now, nanoseconds bit_time) noexcept {
  const nanoseconds from = std::max(recessive_since_, started_);
  if (recessive_since_ == kNever || now <= from) return;
  const auto sequences = (now - from) / (kBits * bit_time);
  left_ -= static_cast<int>(std::min<std::int64_t>(sequences, left_ - 1));  // the last one is finished_at()
}

nanoseconds BusOffRecovery::end(nanoseconds bit_time) const noexcept {
  return std::max(recessive_since_, started_) + left_ * kBits * bit_time;
}

}  // namespace driveline::slaves::can
