#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "driveline/rt/spsc_ring.hpp"
#include "group_path.hpp"

namespace driveline::motion {

/// Paths on their way between planning and the cycle, and what the cycle tells planning of them. Planning and cycle are
/// one thread each.
class PathExchange {
 public:
  PathExchange() : returned_(kReturned) {}

  // Functions for planning.
  /// Offers a path to the cycle, one at a time; take_back() returns it when the axes have left it.
  void offer(GroupPath* path) noexcept { offered_.store(path, std::memory_order_release); }
  /// Returns a path that the axes have left; null: none.
  [[nodiscard]] GroupPath* take_back() noexcept {
    GroupPath* path = nullptr;
    return returned_.try_pop(path) ? path : nullptr;
  }
  /// Ends the path under way in favour of the move with this number; the axes come to rest on it.
  void abort_for(std::uint64_t id) noexcept { abort_for_.store(id, std::memory_order_release); }
  /// Moves with smaller request numbers have been aborted.
  [[nodiscard]] std::uint64_t dropped_below() const noexcept { return dropped_below_.load(std::memory_order_acquire); }
  /// Paths of this epoch and earlier ones get no more moves.
  [[nodiscard]] std::uint64_t ended_epoch() const noexcept { return ended_epoch_.load(std::memory_order_acquire); }
  /// Number of cycles for which the axes have been at the end of the planned path.
  [[nodiscard]] std::uint64_t cycles_at_end() const noexcept { return cycles_at_end_.load(std::memory_order_acquire); }

  // Functions for the cycle. \rtsafe
  /// Returns the offered path; null: none. \rtsafe
  [[nodiscard]] GroupPath* take_offer() noexcept {
    if (offered_.load(std::memory_order_relaxed) == nullptr) return nullptr;
    return offered_.exchange(nullptr, std::memory_order_acquire);
  }
  /// Gives back a path that the cycle does not use any more; null: nothing happens. \rtsafe
  void give_back(GroupPath* path) noexcept {
    if (path != nullptr) static_cast<void>(returned_.try_push(path));
  }
  /// Number of the move in whose favour planning ends the path under way; 0: it does not. \rtsafe
  [[nodiscard]] std::uint64_t aborted_for() const noexcept {
    const auto id = abort_for_.load(std::memory_order_acquire);
    return id > dropped_below_.load(std::memory_order_relaxed) ? id : 0;
  }
  /// Tells that moves with smaller numbers have been aborted. \rtsafe
  void drop_below(std::uint64_t id) noexcept { dropped_below_.store(id, std::memory_order_release); }
  /// Tells that paths of this epoch and earlier ones get no more moves. \rtsafe
  void end_epoch(std::uint64_t epoch) noexcept { ended_epoch_.store(epoch, std::memory_order_release); }
  /// Sets cycles_at_end(). \rtsafe
  void set_cycles_at_end(std::uint64_t cycles) noexcept { cycles_at_end_.store(cycles, std::memory_order_release); }

 private:
  /// Capacity of the queue of returned paths; planning offers one at a time.
  static constexpr std::size_t kReturned = 8;

  rt::SpscRing<GroupPath*> returned_;
  std::atomic<GroupPath*> offered_{nullptr};
  std::atomic<std::uint64_t> abort_for_{0};
  std::atomic<std::uint64_t> dropped_below_{0};
  std::atomic<std::uint64_t> ended_epoch_{0};
  std::atomic<std::uint64_t> cycles_at_end_{0};
};

}  // namespace driveline::motion
