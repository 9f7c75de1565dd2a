#include "driveline/canopen_port/stream_port.hpp"

#include <algorithm>
#include <utility>

namespace driveline::canopen {

using std::chrono::nanoseconds;

SendStatus StreamPort::send(const Frame& frame) noexcept {
  if (!frame.valid()) return SendStatus::kNotValid;
  act(clock_.now());
  const SendStatus status = stream_.broken() ? SendStatus::kDown : write_frame(frame);
  if (status == SendStatus::kSent) ++counters_.sent;
  // A stream that breaks while it is written to takes the frame with it.
  return status == SendStatus::kBusy && stream_.broken() ? SendStatus::kDown : status;
}

std::optional<Frame> StreamPort::take_buffered() noexcept {
  while (!input_.empty()) {
    const char byte = input_.front();
    input_.remove_prefix(1);
    auto frame = take(byte);
    if (!frame) continue;
    if (frame->kind == FrameKind::kError && !options_.error_frames) continue;
    return frame;
  }
  return std::nullopt;
}

/// Reads at most once, so that a flood of bytes without a frame holds nobody up.
bool StreamPort::look_for_frame() noexcept {
  if (next_) return true;
  act(clock_.now());
  auto frame = take_buffered();
  if (!frame) {
    input_ = stream_.read();
    frame = take_buffered();
  }
  if (!frame) return false;
  next_ = ReceivedFrame{*frame, clock_.now()};
  return true;
}

std::optional<ReceivedFrame> StreamPort::receive() noexcept {
  if (!look_for_frame()) return std::nullopt;
  ++counters_.received;
  if (next_->frame.kind == FrameKind::kError) ++counters_.error_frames;
  return std::exchange(next_, std::nullopt);
}

bool StreamPort::wait_readable(nanoseconds deadline) noexcept {
  while (true) {
    if (look_for_frame()) return true;
    if (stream_.ended()) {
      if (std::exchange(told_end_, true)) clock_.sleep_until(deadline);
      return false;
    }
    const nanoseconds until = std::min(deadline, next_act());
    if (!stream_.wait(until)) clock_.sleep_until(until);  // moves a virtual clock, too
    // Past the deadline one more look is due: what has come is there.
    if (clock_.now() >= deadline) return look_for_frame();
  }
}

PortStatistics StreamPort::statistics() const noexcept {
  PortStatistics statistics = counters_;
  statistics.malformed = malformed();
  statistics.down = stream_.broken();
  return statistics;
}

std::optional<char> StreamPort::await_byte(nanoseconds deadline) noexcept {
  while (input_.empty()) {
    input_ = stream_.read();
    if (!input_.empty()) break;
    if (stream_.ended()) return std::nullopt;
    if (!stream_.wait(deadline)) {
      clock_.sleep_until(deadline);  // moves a virtual clock, too
      return std::nullopt;
    }
  }
  const char byte = input_.front();
  input_.remove_prefix(1);
  return byte;
}

}  // namespace driveline::canopen
