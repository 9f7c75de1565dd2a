#include "driveline/slaves/can/transmit_queue.hpp"

#include <algorithm>

namespace driveline::slaves::can {

bool TransmitQueue::push(const Frame& frame) noexcept {
  if (waiting_.size() >= capacity_ || !frame.valid()) {
    ++dropped_;
    return false;
  }
  const std::uint32_t arbitration = canopen::arbitration_field(frame);
  const auto place = std::lower_bound(
      waiting_.begin(), waiting_.end(), arbitration,
      [](const Frame& other, std::uint32_t value) { return canopen::arbitration_field(other) > value; });
  waiting_.insert(place, frame);
  return true;
}

void TransmitQueue::put_back(const Frame& frame) noexcept {
  const std::uint32_t arbitration = canopen::arbitration_field(frame);
  const auto place = std::upper_bound(
      waiting_.begin(), waiting_.end(), arbitration,
      [](std::uint32_t value, const Frame& other) { return canopen::arbitration_field(other) < value; });
  waiting_.insert(place, frame);
}

}  // namespace driveline::slaves::can
