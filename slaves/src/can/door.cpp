#include "driveline/slaves/can/door.hpp"

#include <algorithm>
#include <utility>

namespace driveline::slaves::can {

DoorStatistics& DoorStatistics::operator+=(const DoorStatistics& other) noexcept {
  sent += other.sent;
  received += other.received;
  dropped += other.dropped;
  refused += other.refused;
  missing += other.missing;
  return *this;
}

Door::Door() {
  output_.reserve(kOutputBytes);
}

void Door::connected(Controller& controller) {
  controller_ = &controller;
  bit_rate_ = controller.options().bit_rate;
  leave();
}

void Door::open() {
  leave();
  told_dropped_ = statistics_.dropped;
  restart();
}

void Door::leave() {
  controller_->set_power(false);
  controller_->set_listen_only(false);
  controller_->set_bit_rate(bit_rate_);
  output_.clear();
  closing_ = false;
  left();
}

std::size_t Door::room() const noexcept {
  constexpr std::size_t kShortestFrame = 6;  // "t1230" and the end of its line
  const auto& queue = controller_->queue();
  return kShortestFrame *
         (controller_->options().queue_capacity - std::min(queue.size(), controller_->options().queue_capacity));
}

bool Door::send(const Frame& frame) noexcept {
  const bool sent = controller_->send(frame);
  ++(sent ? statistics_.sent : statistics_.refused);
  return sent;
}

void Door::answer(std::string_view text) {
  if (output_.size() + text.size() <= kOutputBytes) output_ += text;
}

bool Door::pass_on(std::string_view text, std::uint64_t frames) {
  if (text.empty()) return false;
  const bool room = output_.size() + text.size() <= kOutputBytes;
  if (room) output_ += text;
  (room ? statistics_.received : statistics_.dropped) += frames;
  return room;
}

bool Door::take_overrun() noexcept {
  return std::exchange(told_dropped_, statistics_.dropped) != statistics_.dropped;
}

}  // namespace driveline::slaves::can
