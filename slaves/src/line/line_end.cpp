#include "driveline/slaves/line/line_end.hpp"

#include <algorithm>

#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/wire/wire_time.hpp"

namespace driveline::slaves {

LineEnd::LineEnd(SimulatedLine& line, rt::Clock& clock, MasterPort which)
    : line_(line), clock_(clock), which_(which), slots_(kMaxInFlight) {}

LineEnd::Slot* LineEnd::next_slot() noexcept {
  return count_ == slots_.size() ? nullptr : &slots_[(first_ + count_) % slots_.size()];
}

void LineEnd::commit(std::size_t length, std::chrono::nanoseconds arrival) noexcept {
  auto& slot = *next_slot();
  slot.length = length;
  // Frames do not overtake each other on a wire.
  const auto& before = slots_[(first_ + count_ + slots_.size() - 1) % slots_.size()];
  slot.arrival = count_ == 0 ? arrival : std::max(arrival, before.arrival);
  ++count_;
}

void LineEnd::release_held() noexcept {
  if (!held_) return;
  held_ = false;
  first_ = (first_ + 1) % slots_.size();
  --count_;
}

port::SendStatus LineEnd::send(std::span<const std::byte> frame) noexcept {
  return line_.transmit(*this, frame);
}

std::optional<port::ReceivedFrame> LineEnd::receive() noexcept {
  release_held();
  if (count_ == 0) return std::nullopt;
  const auto& slot = slots_[first_];
  if (clock_.now() < slot.arrival) return std::nullopt;
  held_ = true;
  return port::ReceivedFrame{std::span(slot.bytes).first(slot.length), slot.arrival};
}

bool LineEnd::wait_readable(std::chrono::nanoseconds deadline) noexcept {
  const std::size_t waiting = held_ ? count_ - 1 : count_;
  if (waiting == 0) {
    clock_.sleep_until(deadline);
    return false;
  }
  const auto arrival = slots_[(first_ + (held_ ? 1 : 0)) % slots_.size()].arrival;
  clock_.sleep_until(std::min(arrival, deadline));
  return arrival <= deadline;
}

std::chrono::nanoseconds LineEnd::occupy(std::chrono::nanoseconds now, std::chrono::nanoseconds byte_time,
                                         std::size_t bytes) noexcept {
  const auto begin = std::max(now, wire_free_);
  wire_free_ = begin + byte_time * static_cast<std::int64_t>(bytes + wire::kPreambleFcsGap);
  return byte_time.count() == 0 ? now : begin;
}

}  // namespace driveline::slaves
