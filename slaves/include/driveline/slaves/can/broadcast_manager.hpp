#pragma once

#include <optional>
#include <vector>

#include "driveline/slaves/can/node.hpp"

namespace driveline::slaves::can {

/// Cyclic frames and subscriptions of a client, as those of the broadcast manager of SocketCAN (Linux kernel,
/// Documentation/networking/can.rst, "Broadcast Manager protocol sockets"), in the time of the bus. There is one job
/// and one subscription for each identifier.
class BroadcastManager {
 public:
  static constexpr std::size_t kMost = 64;  ///< jobs; as many subscriptions
  /// Shorter periods are as long as this: no frame of eight bytes takes less at 1 Mbit/s.
  static constexpr nanoseconds kShortestPeriod = std::chrono::microseconds{100};

  /// Removes all jobs and subscriptions.
  void clear() noexcept;
  /// Sends the frame now and once in each period; a job with its identifier is replaced. False: there are too many.
  bool add(const Frame& frame, nanoseconds period, nanoseconds now);
  /// Gives the job of its identifier this frame at the next time; false: there is no such job.
  bool update(const Frame& frame) noexcept;
  /// Removes a job; false: there is none.
  bool remove(canopen::Identifier identifier) noexcept;
  /// The client wants the data frames with this identifier, at most one in each `interval`: the newest. With `mask`
  /// only those that differ from the last one in its bits. Replaces a subscription. False: there are too many.
  bool subscribe(canopen::Identifier identifier, nanoseconds interval, const std::optional<Frame>& mask);
  /// Removes a subscription; false: there is none.
  bool unsubscribe(canopen::Identifier identifier) noexcept;

  /// Whether the client gets a received frame now; one that comes too early for its interval waits for take_held().
  [[nodiscard]] bool wants(const Frame& frame, nanoseconds now) noexcept;
  /// The next frame of a job that is due; empty: none is.
  [[nodiscard]] std::optional<Frame> take_due(nanoseconds now) noexcept;
  /// The next frame whose interval has passed; empty: there is none.
  [[nodiscard]] std::optional<Frame> take_held(nanoseconds now) noexcept;
  /// When take_due() or take_held() has a frame; kNever for never.
  [[nodiscard]] nanoseconds next_wake() const noexcept;

 private:
  struct Job {
    Frame frame;
    nanoseconds period{0};
    nanoseconds next{0};
  };
  struct Subscription {
    canopen::Identifier identifier;
    nanoseconds interval{0};
    std::optional<Frame> mask;
    std::optional<Frame> last;  ///< newest content
    std::optional<Frame> held;  ///< waits for open_at
    nanoseconds open_at{0};     ///< the client gets nothing before
  };

  [[nodiscard]] Job* job_of(canopen::Identifier identifier) noexcept;

  std::vector<Job> jobs_;
  std::vector<Subscription> subscriptions_;
};

}  // namespace driveline::slaves::can
