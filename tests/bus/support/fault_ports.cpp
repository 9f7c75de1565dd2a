#include "fault_ports.hpp"

#include <algorithm>

#include "driveline/bytes/endian.hpp"

namespace driveline::bus_test {

SourceAddress source_of(std::span<const std::byte> frame) noexcept {
  SourceAddress source{};
  std::copy_n(frame.begin() + 6, source.size(), source.begin());
  source[0] &= ~std::byte{0x02};
  return source;
}

namespace {

/// Removes the source of the frame from `sources`; true: it was there.
bool take(std::vector<SourceAddress>& sources, std::span<const std::byte> frame) {
  const auto found = std::find(sources.begin(), sources.end(), source_of(frame));
  if (found == sources.end()) return false;
  sources.erase(found);
  return true;
}

}  // namespace

port::SendStatus LossyPort::send(std::span<const std::byte> frame) noexcept {
  if (!loses_(sent_++, frame)) return inner_.send(frame);
  ++lost_;
  if (direction_ == Direction::kOut) return port::SendStatus::kSent;
  doomed_.push_back(source_of(frame));
  return inner_.send(frame);
}

std::optional<port::ReceivedFrame> LossyPort::receive() noexcept {
  for (;;) {
    auto frame = inner_.receive();
    if (!frame || !take(doomed_, frame->bytes)) return frame;
  }
}

port::SendStatus LatePort::send(std::span<const std::byte> frame) noexcept {
  if (delays_(sent_++)) late_.push_back(source_of(frame));
  return inner_.send(frame);
}

std::optional<port::ReceivedFrame> LatePort::receive() noexcept {
  if (!kept_.empty() && kept_.front().due <= clock_.now()) {
    handed_out_ = std::move(kept_.front().bytes);
    kept_.pop_front();
    return port::ReceivedFrame{handed_out_, clock_.now()};
  }
  for (;;) {
    auto frame = inner_.receive();
    if (!frame || !take(late_, frame->bytes)) return frame;
    ++delayed_;
    kept_.push_back({{frame->bytes.begin(), frame->bytes.end()}, clock_.now() + delay_});
  }
}

bool LatePort::wait_readable(std::chrono::nanoseconds deadline) noexcept {
  const auto due = kept_.empty() ? deadline : std::min(deadline, kept_.front().due);
  return inner_.wait_readable(due) || (!kept_.empty() && kept_.front().due <= clock_.now());
}

port::SendStatus ChangingPort::send(std::span<const std::byte> frame) noexcept {
  if (!out_) return inner_.send(frame);
  std::vector<std::byte> changed(frame.begin(), frame.end());
  out_(changed);
  return inner_.send(changed);
}

std::optional<port::ReceivedFrame> ChangingPort::receive() noexcept {
  auto frame = inner_.receive();
  if (!frame || !back_) return frame;
  bytes_.assign(frame->bytes.begin(), frame->bytes.end());
  back_(bytes_);
  return port::ReceivedFrame{bytes_, frame->time};
}

FirstDatagram first_datagram(std::span<const std::byte> frame) noexcept {
  constexpr std::size_t kHeader = 16;
  auto word = [&](std::size_t at) { return bytes::load_le<std::uint16_t>(frame.subspan(kHeader + at, 2)); };
  return {static_cast<wire::Command>(frame[kHeader]), word(2), word(4), frame.subspan(kHeader + 10, word(6) & 0x7FFU)};
}

}  // namespace driveline::bus_test
