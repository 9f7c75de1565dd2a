#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "driveline/motion/group/group_request.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "group_request_table.hpp"
#include "group_stops.hpp"

namespace driveline::motion {

/// A request in the queue to the cycle.
struct NumberedGroupRequest {
  std::uint64_t id = 0;    ///< number from GroupRequestTable::add()
  GroupRequest request{};  ///< the request
};

/// Requests to a group on their way to the cycle: a queue, and a lane for stops, which overtake it.
class GroupInbox {
 public:
  /// Numbers of requests: those in the queue, and those in the lane of stops.
  struct Count {
    std::uint64_t queued = 0;
    std::uint64_t stops = 0;
  };

  /// `table` must outlive this object.
  explicit GroupInbox(GroupRequestTable& table) : table_(table), requests_(kRequests) {}

  // Functions for submitting threads, one at a time.
  /// Submits a request and returns its number; 0: the queue is full. A stop, a halt, an interrupt and a disable are
  /// taken by the next cycle, whatever is queued.
  [[nodiscard]] std::uint64_t submit(const GroupRequest& request) noexcept;
  /// Number of requests that have been submitted.
  [[nodiscard]] Count submitted() const noexcept { return {queued_, stops_.puts()}; }

  /// Whether the cycle has taken this many requests. Any thread.
  [[nodiscard]] bool has_taken(const Count& count) const noexcept {
    return taken_.load(std::memory_order_acquire) >= count.queued &&
           stops_taken_.load(std::memory_order_acquire) >= count.stops;
  }

  // Functions for the cycle.
  /// Calls `receive` with the number and the content of all stops, in the order of their numbers, and then of some
  /// queued requests: stops cost no planning. \rtsafe
  template <typename Receive>
  void take(Receive&& receive) noexcept {
    stops_.take_all(
        [&](std::size_t, const GroupStopLane::Stop& stop, bool) noexcept { receive(stop.id, stop.request); });
    NumberedGroupRequest next;
    for (std::size_t i = 0; i < kRequestsPerCycle && requests_.try_pop(next); ++i) {
      if (!overtaken(next)) receive(next.id, next.request);
      ++taken_now_;
    }
  }
  /// Lets has_taken() see what take() has taken. \rtsafe
  void publish() noexcept {
    taken_.store(taken_now_, std::memory_order_release);
    stops_taken_.store(stops_.puts_taken(), std::memory_order_release);
  }

 private:
  static constexpr std::size_t kRequests = 256;
  static constexpr std::size_t kRequestsPerCycle = 4;

  [[nodiscard]] bool overtaken(const NumberedGroupRequest& next) noexcept;

  GroupRequestTable& table_;
  rt::SpscRing<NumberedGroupRequest> requests_;
  std::uint64_t queued_ = 0;     ///< requests put into requests_; used by submitting threads
  std::uint64_t taken_now_ = 0;  ///< requests taken out of it; used by the cycle
  GroupStopLane stops_{1};
  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> stops_taken_{0};
};

}  // namespace driveline::motion
