#include "driveline/slaves/can/bus_off_recovery.hpp"

#include <algorithm>

namespace driveline::slaves::can {

void BusOffRecovery::start(nanoseconds now) noexcept {
  left_ = kSequences;
  started_ = now;
}

void BusOffRecovery::wire_recessive(nanoseconds since) noexcept {
  recessive_since_ = since;
}

void BusOffRecovery::wire_dominant(nanoseconds now, nanoseconds bit_time) noexcept {
  const nanoseconds from = std::max(recessive_since_, started_);
  if (left_ != 0 && recessive_since_ != kNever && now > from) {
    const auto sequences = (now - from) / (kBits * bit_time);
    left_ -= static_cast<int>(std::min<std::int64_t>(sequences, left_ - 1));  // the last one is finished_at()
  }
  recessive_since_ = kNever;
}

nanoseconds BusOffRecovery::finished_at(nanoseconds bit_time) const noexcept {
  if (left_ == 0 || recessive_since_ == kNever) return kNever;
  return std::max(recessive_since_, started_) + left_ * kBits * bit_time;
}

}  // namespace driveline::slaves::can
