#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "driveline/ecat_master/cyclic/cycle_task.hpp"
#include "driveline/ecat_master/single_axis/setpoint_feed.hpp"
#include "driveline/trajectory/setpoint.hpp"
#include "stream/stream_axes.hpp"
#include "stream/stream_session.hpp"

namespace driveline::runtime {

/// The sessions of all clients in the cycle: a task before the motion that takes their records, and a feed for each
/// axis of the line by which the axis gets its setpoints.
class StreamHub final : public ecat_master::CycleTask {
 public:
  /// Clients at a time.
  static constexpr std::size_t kMostSessions = 32;

  /// `axes` must outlive it.
  StreamHub(StreamAxes& axes, std::size_t axis_count);
  ~StreamHub() override;

  /// What an axis follows.
  [[nodiscard]] ecat_master::SetpointFeed& feed(std::size_t axis) noexcept;

  // The owner's thread.
  /// Hands a session to the cycle; it must live until holds() says no. False: there are too many.
  [[nodiscard]] bool add(StreamSession& session) noexcept;
  /// There are as many sessions as can be.
  [[nodiscard]] bool full() const noexcept;
  /// The cycle still uses it.
  [[nodiscard]] bool holds(const StreamSession& session) const noexcept;

  // The cycle's side.
  void update(const ecat_master::TaskCycle& cycle) noexcept override;

 private:
  class Feed;

  void bind(StreamSession& session) noexcept;
  void run(std::atomic<StreamSession*>& slot, const ecat_master::TaskCycle& cycle) noexcept;
  void unbind(StreamSession& session, bool over) noexcept;

  StreamAxes& axes_;
  std::vector<std::unique_ptr<Feed>> feeds_;
  std::array<std::atomic<StreamSession*>, kMostSessions> slots_{};
};

}  // namespace driveline::runtime
