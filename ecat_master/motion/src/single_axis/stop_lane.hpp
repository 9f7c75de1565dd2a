#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "driveline/rt/triple_buffer.hpp"

namespace driveline::motion {

/// Passes stops to the cycle beside the queue of all other requests, so that the next cycle takes them whatever else
/// waits. Each receiver (an axis or a group) has one place per kind of stop: the lane is never full, and a cycle takes
/// all that is in it. `Kind` is an enumeration from 0 to `Kinds` - 1 with increasing strength.
///
/// A stop overtakes the requests in the queue. The cycle recognises those by their numbers, which come from the same
/// count: a request with a lower number than a stop that was taken() is older than it.
template <typename Request, typename Kind, std::size_t Kinds>
class StopLane {
 public:
  /// A stop in the lane.
  struct Stop {
    std::uint64_t id = 0;  ///< number of the request; 0: none
    Request request{};
  };

  /// Allocates the places of all receivers.
  explicit StopLane(std::size_t receivers) : receivers_(receivers), places_(std::make_unique<Place[]>(receivers)) {}

  // Submitting threads, one at a time.
  /// Puts a stop into its place. Returns the number of the previous stop of the same kind, which the cycle may not have
  /// taken; 0: none. \rtsafe
  std::uint64_t put(std::size_t receiver, Kind kind, const Stop& stop) noexcept {
    auto& place = places_[receiver];
    const auto previous = place.latest[index(kind)].id;
    place.latest[index(kind)] = stop;
    place.inbox.write(place.latest);
    puts_.store(++put_, std::memory_order_release);
    return previous;
  }
  /// Number of stops that have been put. \rtsafe
  [[nodiscard]] std::uint64_t puts() const noexcept { return put_; }

  // The cycle.
  /// Takes all stops: calls `take(receiver, stop, superseded)` for each, those of a receiver in the order of their
  /// numbers. `superseded`: a later stop of the receiver, which follows, is at least as strong. Without a new stop it
  /// costs one comparison. \rtsafe if `take` is.
  template <typename Take>
  void take_all(const Take& take) noexcept {
    const auto puts = puts_.load(std::memory_order_acquire);
    if (puts == puts_taken_) return;
    puts_taken_ = puts;
    for (std::size_t receiver = 0; receiver < receivers_; ++receiver) {
      if (places_[receiver].inbox.update()) take_from(receiver, take);
    }
  }
  /// Number of stops that had been put when take_all() last found some. \rtsafe
  [[nodiscard]] std::uint64_t puts_taken() const noexcept { return puts_taken_; }
  /// Number of the last stop of a kind that was taken; 0: none. \rtsafe
  [[nodiscard]] std::uint64_t taken(std::size_t receiver, Kind kind) const noexcept {
    return places_[receiver].taken[index(kind)];
  }
  /// Number of the last stop of any kind from `weakest` on that was taken; 0: none. \rtsafe
  [[nodiscard]] std::uint64_t taken_from(std::size_t receiver, Kind weakest) const noexcept {
    const auto& taken = places_[receiver].taken;
    return *std::max_element(taken.begin() + static_cast<std::ptrdiff_t>(index(weakest)), taken.end());
  }

 private:
  using Stops = std::array<Stop, Kinds>;
  struct Place {
    Stops latest{};  ///< used by submitting threads
    rt::TripleBuffer<Stops> inbox{};
    std::array<std::uint64_t, Kinds> taken{};  ///< used by the cycle: last number of each kind
  };
  static constexpr std::size_t index(Kind kind) noexcept { return static_cast<std::size_t>(kind); }

  template <typename Take>
  void take_from(std::size_t receiver, const Take& take) noexcept {
    auto& place = places_[receiver];
    const auto& stops = place.inbox.read();
    std::array<std::size_t, Kinds> order{};
    std::size_t count = 0;
    for (std::size_t kind = 0; kind < Kinds; ++kind) {
      if (stops[kind].id > place.taken[kind]) order[count++] = kind;
    }
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
              [&stops](std::size_t one, std::size_t other) { return stops[one].id < stops[other].id; });
    for (std::size_t i = 0; i < count; ++i) {
      const auto kind = order[i];
      const auto later = std::span(order).subspan(i + 1, count - i - 1);
      const bool superseded =
          std::any_of(later.begin(), later.end(), [kind](std::size_t other) { return other > kind; });
      place.taken[kind] = stops[kind].id;
      take(receiver, stops[kind], superseded);
    }
  }

  std::size_t receivers_;
  std::unique_ptr<Place[]> places_;
  std::uint64_t put_ = 0;  ///< used by submitting threads
  std::atomic<std::uint64_t> puts_{0};
  std::uint64_t puts_taken_ = 0;  ///< used by the cycle
};

}  // namespace driveline::motion
