#pragma once

#include <array>
#include <cstddef>

#include "driveline/slaves/position_servo/move.hpp"

namespace driveline::slaves::position_servo {

/// The 32 moves that can wait (lines 4045 and 4108), first in, first out.
class MoveQueue {
 public:
  /// Number of moves that can wait.
  static constexpr std::size_t kCapacity = 32;

  /// Adds a move; returns false if the queue is full. \rtsafe
  [[nodiscard]] bool push(const Move& move) noexcept {
    if (full()) return false;
    moves_[(first_ + count_) % kCapacity] = move;
    ++count_;
    return true;
  }
  /// Removes the first move; the queue must not be empty. \rtsafe
  void pop() noexcept {
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
  /// Returns the first move; the queue must not be empty. \rtsafe
  [[nodiscard]] const Move& front() const noexcept { return moves_[first_]; }
  /// Removes all moves. \rtsafe
  void clear() noexcept { count_ = 0; }
  /// Returns the number of moves that wait. \rtsafe
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  /// Whether no move waits. \rtsafe
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  /// Whether there is no room for another move. \rtsafe
  [[nodiscard]] bool full() const noexcept { return count_ == kCapacity; }

 private:
  std::array<Move, kCapacity> moves_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace driveline::slaves::position_servo
