#include "stream/stream_hub.hpp"

#include <algorithm>

namespace driveline::runtime {

/// Setpoints of an axis, from the session that owns it.
class StreamHub::Feed final : public motion::SetpointFeed {
 public:
  [[nodiscard]] std::size_t axis_count() const noexcept override { return 1; }
  void join(std::size_t /*axis*/, const trajectory::AxisSetpoint& /*from*/) noexcept override {
    if (session_ != nullptr) session_->joined(member_);
  }
  void leave(std::size_t /*axis*/) noexcept override {
    if (session_ != nullptr) session_->left(member_);
  }
  [[nodiscard]] bool next(double /*period_s*/, std::span<trajectory::AxisSetpoint> setpoints) noexcept override {
    const auto* setpoint = session_ != nullptr ? session_->setpoint(member_) : nullptr;
    if (setpoint == nullptr) return false;
    setpoints[0] = *setpoint;
    return true;
  }

  [[nodiscard]] StreamSession* session() const noexcept { return session_; }
  void use(StreamSession* session, std::size_t member) noexcept {
    session_ = session;
    member_ = member;
  }

 private:
  StreamSession* session_ = nullptr;
  std::size_t member_ = 0;
};

StreamHub::StreamHub(StreamAxes& axes, std::size_t axis_count) : axes_(axes) {
  for (std::size_t i = 0; i < axis_count; ++i) feeds_.push_back(std::make_unique<Feed>());
}

StreamHub::~StreamHub() = default;

motion::SetpointFeed& StreamHub::feed(std::size_t axis) noexcept {
  return *feeds_[axis];
}

bool StreamHub::add(StreamSession& session) noexcept {
  for (auto& slot : slots_) {
    StreamSession* none = nullptr;
    if (slot.compare_exchange_strong(none, &session, std::memory_order_release, std::memory_order_relaxed)) return true;
  }
  return false;
}

bool StreamHub::full() const noexcept {
  return std::all_of(slots_.begin(), slots_.end(),
                     [](const auto& slot) { return slot.load(std::memory_order_relaxed) != nullptr; });
}

bool StreamHub::holds(const StreamSession& session) const noexcept {
  return std::any_of(slots_.begin(), slots_.end(),
                     [&](const auto& slot) { return slot.load(std::memory_order_acquire) == &session; });
}

void StreamHub::update(const motion::TaskCycle& cycle) noexcept {
  // Bind all sessions before any of them runs, so that the feed of a lost axis is released before another session gets
  // it.
  for (auto& slot : slots_) {
    if (auto* session = slot.load(std::memory_order_acquire)) bind(*session);
  }
  for (auto& slot : slots_) run(slot, cycle);
}

void StreamHub::run(std::atomic<StreamSession*>& slot, const motion::TaskCycle& cycle) noexcept {
  auto* session = slot.load(std::memory_order_acquire);
  if (session == nullptr) return;
  const bool over = !session->update(cycle, axes_);
  unbind(*session, over);
  if (over) slot.store(nullptr, std::memory_order_release);
}

void StreamHub::bind(StreamSession& session) noexcept {
  for (std::size_t i = 0; i < session.members().size(); ++i) {
    auto& feed = *feeds_[session.members()[i].axis];
    if (feed.session() != nullptr || !session.commands(i)) continue;
    feed.use(&session, i);
    session.bind(i, true);
  }
}

/// Releases the feeds of a session that is over, or of axes that it has lost.
void StreamHub::unbind(StreamSession& session, bool over) noexcept {
  for (std::size_t i = 0; i < session.members().size(); ++i) {
    auto& feed = *feeds_[session.members()[i].axis];
    const bool keeps = !over && (session.follows(i) || session.commands(i));
    if (feed.session() != &session || keeps) continue;
    feed.use(nullptr, 0);
    session.bind(i, false);
  }
}

}  // namespace driveline::runtime
