#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/motion/single_axis/setpoint_feed.hpp"
#include "driveline/trajectory/setpoint.hpp"
#include "stream/stream_axes.hpp"
#include "stream/stream_session.hpp"

namespace driveline::runtime {

/// The sessions of all clients in the cycle: a task before the motion that processes their records, and a feed for each
/// axis of the line that supplies its setpoints.
class StreamHub final : public motion::CycleTask {
 public:
  /// Most clients at a time.
  static constexpr std::size_t kMaxSessions = 32;

  /// `axes` must outlive it.
  StreamHub(StreamAxes& axes, std::size_t axis_count);
  ~StreamHub() override;

  /// Returns the feed that an axis follows.
  [[nodiscard]] motion::SetpointFeed& feed(std::size_t axis) noexcept;

  // Called on the owner's thread.
  /// Adds a session to the cycle; it must live until holds() returns false. False: there are too many sessions.
  [[nodiscard]] bool add(StreamSession& session) noexcept;
  /// Whether no further session can be added.
  [[nodiscard]] bool full() const noexcept;
  /// Whether the cycle still uses the session.
  [[nodiscard]] bool holds(const StreamSession& session) const noexcept;

  // Called by the cycle.
  void update(const motion::TaskCycle& cycle) noexcept override;

 private:
  class Feed;

  void bind(StreamSession& session) noexcept;
  void run(std::atomic<StreamSession*>& slot, const motion::TaskCycle& cycle) noexcept;
  void unbind(StreamSession& session, bool over) noexcept;

  StreamAxes& axes_;
  std::vector<std::unique_ptr<Feed>> feeds_;
  std::array<std::atomic<StreamSession*>, kMaxSessions> slots_{};
};

}  // namespace driveline::runtime
