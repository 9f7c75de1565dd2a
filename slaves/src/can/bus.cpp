#include "driveline/slaves/can/bus.hpp"

#include <algorithm>

namespace driveline::slaves::can {

Bus::Bus(const Wiring& wiring, std::uint64_t seed) {
  conditions_.wiring = wiring;
  conditions_.random = RandomSource(seed);
}

Controller& Bus::attach(Node& node, const ControllerOptions& options) {
  take_apart();
  Controller& added = *controllers_.emplace_back(std::make_unique<Controller>(node, options));
  node.connected(added);
  added.look();
  return added;
}

void Bus::inject(const FrameFault& fault) {
  std::erase_if(conditions_.faults, [](const FrameFault& one) { return one.count == 0; });
  conditions_.faults.push_back(fault);
}

void Bus::withdraw(std::uint32_t number) {
  std::erase_if(conditions_.faults, [number](const FrameFault& one) { return one.number == number; });
}

bool Bus::injected(std::uint32_t number) const noexcept {
  const auto& faults = conditions_.faults;
  return std::any_of(faults.begin(), faults.end(),
                     [number](const FrameFault& one) { return one.number == number && one.count != 0; });
}

void Bus::cut(std::size_t behind) {
  take_apart();
  cuts_.insert(behind);
}

void Bus::mend(std::size_t behind) {
  take_apart();
  cuts_.erase(behind);
}

void Bus::set_wiring(const Wiring& wiring) {
  take_apart();
  conditions_.wiring = wiring;
}

void Bus::take_apart() {
  for (Segment& segment : segments_) idle_at_ = std::max(idle_at_, segment.interrupt(now_));
  segments_.clear();
}

/// Divides the trunk into its pieces.
void Bus::arrange() {
  if (!segments_.empty()) return;
  const nanoseconds idle_at = std::max(idle_at_, now_);
  const auto all = std::span<const std::unique_ptr<Controller>>(controllers_);
  std::size_t first = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool end = i + 1 == all.size();
    if (!end && cuts_.count(i) == 0) continue;
    const unsigned terminators = (first == 0 && conditions_.wiring.first_terminated ? 1U : 0U) +
                                 (end && conditions_.wiring.last_terminated ? 1U : 0U);
    segments_.emplace_back(all.subspan(first, i + 1 - first), first, terminators, conditions_, idle_at);
    first = i + 1;
  }
}

nanoseconds Bus::next_event() const noexcept {
  look_at_nodes();
  return next_due();
}

void Bus::look_at_nodes() const noexcept {
  for (const auto& one : controllers_) one->look();
}

nanoseconds Bus::next_due() const noexcept {
  if (segments_.empty() && !controllers_.empty()) return now_;
  nanoseconds next = kNever;
  for (const auto& one : controllers_) next = std::min(next, one->wake_);
  for (const Segment& segment : segments_) next = std::min(next, segment.next_event());
  return std::max(next, now_);
}

void Bus::advance_nodes() {
  for (const auto& one : controllers_) {
    if (one->wake_ <= now_) one->advance(now_);
  }
}

void Bus::transmit() {
  arrange();
  for (Segment& segment : segments_) segment.start(now_);
}

void Bus::advance(nanoseconds until) {
  look_at_nodes();
  for (;;) {
    arrange();
    advance_nodes();
    for (Segment& segment : segments_) segment.start(now_);
    const nanoseconds next = next_due();
    if (next > until) break;
    now_ = next;
    for (Segment& segment : segments_) segment.advance(now_);
  }
  now_ = std::max(now_, until);
}

}  // namespace driveline::slaves::can
