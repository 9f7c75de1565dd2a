#include "driveline/slaves/canopen/outbox.hpp"

namespace driveline::slaves::cia301 {

void Outbox::send(const Frame& frame) noexcept {
  if (controller_ == nullptr || !controller_->send(frame)) ++lost_;
}

void Outbox::send_at(nanoseconds time, const Frame& frame) noexcept {
  if (count_ == kDelayed) {
    ++lost_;
    return;
  }
  delayed_[(first_ + count_) % kDelayed] = {time, frame};
  ++count_;
}

void Outbox::advance(nanoseconds now) noexcept {
  for (; count_ != 0 && delayed_[first_].time <= now; --count_) {
    send(delayed_[first_].frame);
    first_ = (first_ + 1) % kDelayed;
  }
}

void Outbox::clear() noexcept {
  count_ = 0;
  if (controller_ != nullptr) controller_->queue().clear();
}

}  // namespace driveline::slaves::cia301
