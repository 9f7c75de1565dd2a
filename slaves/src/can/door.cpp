#include "driveline/slaves/can/door.hpp"

#include <utility>

namespace driveline::slaves::can {

Door::Door() {
  output_.reserve(kOutputBytes);
}

bool Door::send(const Frame& frame) noexcept {
  const bool sent = controller_->send(frame);
  ++(sent ? statistics_.sent : statistics_.refused);
  return sent;
}

void Door::answer(std::string_view text) {
  if (output_.size() + text.size() <= kOutputBytes) output_ += text;
}

void Door::pass_on(std::string_view text) {
  if (text.empty()) return;
  const bool room = output_.size() + text.size() <= kOutputBytes;
  if (room) output_ += text;
  ++(room ? statistics_.received : statistics_.dropped);
}

bool Door::take_overrun() noexcept {
  return std::exchange(told_dropped_, statistics_.dropped) != statistics_.dropped;
}

}  // namespace driveline::slaves::can
