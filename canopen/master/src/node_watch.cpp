#include "driveline/canopen_master/node_watch.hpp"

#include <algorithm>

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

constexpr int kHeartbeats = 3;  ///< heartbeats that a node may miss, where the plan has no tolerance

}  // namespace

NodeWatch::NodeWatch(const ErrorControlPlan& plan, std::uint8_t id) noexcept : id_(id), guard_time_(plan.guard_time) {
  if (plan.heartbeat.count() > 0) {
    patience_ = plan.tolerance.count() > 0 ? plan.tolerance : plan.heartbeat * kHeartbeats;
  } else if (plan.guard_time.count() > 0) {
    patience_ = plan.guard_time * std::max<int>(1, plan.life_time_factor);
  }
}

void NodeWatch::begin(nanoseconds now, bool restarted) noexcept {
  if (restarted) toggle_ = false;
  running_ = tells_state();
  deadline_ = now + patience_;
  next_guard_ = now;
}

bool NodeWatch::receive(const ErrorControl& message, nanoseconds time) noexcept {
  // Messages that waited in a queue may be old.
  deadline_ = std::max(deadline_, time + patience_);
  if (guard_time_.count() == 0 || message.state == NmtState::kInitialising) return true;
  const bool right = message.toggle == toggle_;
  toggle_ = !message.toggle;
  return right;
}

std::optional<Frame> NodeWatch::outgoing(nanoseconds now) const noexcept {
  if (!running_ || guard_time_.count() == 0 || now < next_guard_) return std::nullopt;
  return Frame::remote({predefined::kErrorControl + id_}, ErrorControl::kSize);
}

void NodeWatch::sent(nanoseconds now) noexcept {
  // On a grid, so that many nodes do not slowly come together; a late heartbeat does not cause a burst.
  next_guard_ += guard_time_;
  if (next_guard_ <= now) next_guard_ = now + guard_time_;
}

}  // namespace driveline::canopen
