#include "driveline/slaves/can/broadcast_manager.hpp"

#include <algorithm>
#include <utility>

namespace driveline::slaves::can {
namespace {

/// Whether bits of the mask have changed.
bool differs(const Frame& one, const Frame& other, const Frame& mask) noexcept {
  for (std::size_t i = 0; i < one.data.size(); ++i) {
    if (((one.data[i] ^ other.data[i]) & mask.data[i]) != std::byte{0}) return true;
  }
  return false;
}

}  // namespace

void BroadcastManager::clear() noexcept {
  jobs_.clear();
  subscriptions_.clear();
}

BroadcastManager::Job* BroadcastManager::job_of(canopen::Identifier identifier) noexcept {
  const auto found =
      std::find_if(jobs_.begin(), jobs_.end(), [&](const Job& one) { return one.frame.identifier == identifier; });
  return found == jobs_.end() ? nullptr : &*found;
}

bool BroadcastManager::add(const Frame& frame, nanoseconds period, nanoseconds now) {
  const Job job{frame, std::max(period, kShortestPeriod), now};
  if (Job* known = job_of(frame.identifier)) {
    *known = job;
    return true;
  }
  if (jobs_.size() == kMost) return false;
  jobs_.push_back(job);
  return true;
}

bool BroadcastManager::update(const Frame& frame) noexcept {
  Job* job = job_of(frame.identifier);
  if (job != nullptr) job->frame = frame;
  return job != nullptr;
}

bool BroadcastManager::remove(canopen::Identifier identifier) noexcept {
  return std::erase_if(jobs_, [&](const Job& one) { return one.frame.identifier == identifier; }) > 0;
}

bool BroadcastManager::subscribe(canopen::Identifier identifier, nanoseconds interval,
                                 const std::optional<Frame>& mask) {
  static_cast<void>(unsubscribe(identifier));
  if (subscriptions_.size() == kMost) return false;
  subscriptions_.push_back({identifier, interval, mask, {}, {}, nanoseconds{0}});
  return true;
}

bool BroadcastManager::unsubscribe(canopen::Identifier identifier) noexcept {
  return std::erase_if(subscriptions_, [&](const Subscription& one) { return one.identifier == identifier; }) > 0;
}

bool BroadcastManager::wants(const Frame& frame, nanoseconds now) noexcept {
  if (frame.kind != canopen::FrameKind::kData) return false;
  const auto found = std::find_if(subscriptions_.begin(), subscriptions_.end(),
                                  [&](const Subscription& one) { return one.identifier == frame.identifier; });
  if (found == subscriptions_.end()) return false;
  if (found->mask && found->last && !differs(frame, *found->last, *found->mask)) return false;
  found->last = frame;
  if (now < found->open_at) {
    found->held = frame;
    return false;
  }
  found->open_at = now + found->interval;
  return true;
}

std::optional<Frame> BroadcastManager::take_due(nanoseconds now) noexcept {
  const auto due = std::find_if(jobs_.begin(), jobs_.end(), [now](const Job& one) { return one.next <= now; });
  if (due == jobs_.end()) return std::nullopt;
  due->next += due->period * (1 + (now - due->next) / due->period);  // times that have passed are not made up for
  return due->frame;
}

std::optional<Frame> BroadcastManager::take_held(nanoseconds now) noexcept {
  const auto due = std::find_if(subscriptions_.begin(), subscriptions_.end(),
                                [now](const Subscription& one) { return one.held && one.open_at <= now; });
  if (due == subscriptions_.end()) return std::nullopt;
  due->open_at = now + due->interval;
  return std::exchange(due->held, std::nullopt);
}

nanoseconds BroadcastManager::next_wake() const noexcept {
  nanoseconds next = kNever;
  for (const Job& one : jobs_) next = std::min(next, one.next);
  for (const Subscription& one : subscriptions_) {
    if (one.held) next = std::min(next, one.open_at);
  }
  return next;
}

}  // namespace driveline::slaves::can
