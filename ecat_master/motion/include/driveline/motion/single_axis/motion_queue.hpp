#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace driveline::motion {

/// Motions of type `Move` that wait for the one under way, at most `kSize`, in the order of their requests. Allocates
/// no memory; all functions are \rtsafe.
template <typename Move, std::size_t kSize>
class MotionQueue {
 public:
  /// Whether no motion waits.
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  /// Returns the number of waiting motions.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Returns the motion that starts first; there must be one.
  [[nodiscard]] const Move& front() const noexcept { return moves_[0]; }
  /// Returns the motion that starts last; there must be one.
  [[nodiscard]] const Move& back() const noexcept { return moves_[size_ - 1]; }
  /// Iterates over the waiting motions, in their order.
  [[nodiscard]] Move* begin() noexcept { return moves_.data(); }
  /// See begin().
  [[nodiscard]] Move* end() noexcept { return moves_.data() + size_; }

  /// Appends a motion. Returns false when the queue is full.
  [[nodiscard]] bool push(const Move& move) noexcept {
    if (size_ == kSize) return false;
    moves_[size_++] = move;
    return true;
  }
  /// Removes the first motion and returns it; there must be one.
  [[nodiscard]] Move pop() noexcept {
    const auto first = moves_[0];
    std::copy(begin() + 1, end(), begin());
    --size_;
    return first;
  }
  /// Removes all motions.
  void clear() noexcept { size_ = 0; }

 private:
  std::array<Move, kSize> moves_{};
  std::size_t size_ = 0;
};

}  // namespace driveline::motion
