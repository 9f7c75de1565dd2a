#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "driveline/motion/group/group_request.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// A path of a group: planned by one thread while the cycle follows it. It starts where the axes are at standstill, and
/// continues as long as moves are added; a final stop ends it.
class GroupPath {
 public:
  /// Maximum number of moves that are planned and not done yet.
  static constexpr std::size_t kUnderWay = 1024;

  /// State of the axes on the path.
  struct Place {
    std::uint64_t move = 0;  ///< number of the move, starting at 0
    double length = 0.0;     ///< distance since the start of the path, m or rad
    double speed = 0.0;      ///< m/s or rad/s, negative when moving backwards
    bool at_rest = true;     ///< all axes are at standstill
    bool at_end = true;      ///< at the end of the planned path, in the requested direction
  };

  virtual ~GroupPath() = default;
  GroupPath(const GroupPath&) = delete;
  GroupPath& operator=(const GroupPath&) = delete;

  /// Number of the standstill at which the path starts: AxisGroup::Standing::epoch.
  [[nodiscard]] std::uint64_t epoch() const noexcept { return epoch_; }

  // Functions for planning.
  /// Whether another move can be added.
  [[nodiscard]] bool has_room() const noexcept {
    return added_.load(std::memory_order_relaxed) - done_.load(std::memory_order_acquire) < kUnderWay;
  }
  /// Adds a move with absolute positions; returns a sentence if that is not possible. The cycle sees it after flush().
  [[nodiscard]] virtual tl::expected<void, trajectory::PathMoveError> add(const GroupMove& move) = 0;
  /// Assigns a request to the move that was added last; to be called before flush().
  void note(std::uint64_t request) noexcept {
    const auto added = added_.load(std::memory_order_relaxed);
    requests_[added % kUnderWay] = request;
    added_.store(added + 1, std::memory_order_release);
  }
  /// Makes the axes stop after the last move.
  virtual void finish() = 0;
  /// Hands planned moves over to the cycle; false: incomplete, call it again later.
  [[nodiscard]] virtual bool flush() = 0;
  /// To be called after finish(), once flush() has returned true: all moves are done at the end of the planned path.
  void complete() noexcept { complete_.store(added_.load(std::memory_order_relaxed), std::memory_order_release); }
  /// Whether all added moves have been completed and are done.
  [[nodiscard]] bool idle() const noexcept { return done_.load(std::memory_order_acquire) == added_; }
  /// End of the last move, one value per axis.
  [[nodiscard]] virtual std::span<const double> target() const noexcept = 0;
  /// Calls `each` with the requests of the moves that the cycle had not settled when it returned the path.
  template <typename Each>
  void unsettled(Each&& each) const {
    for (auto move = done_.load(std::memory_order_relaxed); move < added_.load(std::memory_order_relaxed); ++move)
      each(requests_[move % kUnderWay]);
  }

  // Functions for the cycle. \rtsafe
  /// See trajectory::ContourFollower. \rtsafe
  virtual void set_override(double share) noexcept = 0;
  virtual void hold(bool held) noexcept = 0;
  virtual void reverse(bool backwards) noexcept = 0;
  /// Computes the setpoints of the next cycle. \rtsafe
  virtual Place step(std::span<trajectory::AxisSetpoint> setpoints) noexcept = 0;

  /// Number of moves that are done when the end of the planned path is reached; to be read before step(). \rtsafe
  [[nodiscard]] std::uint64_t completed() const noexcept { return complete_.load(std::memory_order_acquire); }
  /// Request of the next move that is not done; 0: none. \rtsafe
  [[nodiscard]] std::uint64_t next_request() const noexcept {
    const auto done = done_.load(std::memory_order_relaxed);
    return done < added_.load(std::memory_order_acquire) ? requests_[done % kUnderWay] : 0;
  }
  /// Number of the next move that is not done. \rtsafe
  [[nodiscard]] std::uint64_t done() const noexcept { return done_.load(std::memory_order_relaxed); }
  /// Settles that move: it is done, or will never be. \rtsafe
  void settle_one() noexcept { done_.store(done_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  /// Request of a move that is not done. \rtsafe
  [[nodiscard]] std::uint64_t request_of(std::uint64_t move) const noexcept { return requests_[move % kUnderWay]; }

 protected:
  explicit GroupPath(std::uint64_t epoch) noexcept : epoch_(epoch) {}
  /// Error for a target with the wrong number of values.
  [[nodiscard]] static trajectory::PathMoveError wrong_count(std::size_t values, std::size_t axes) {
    return {"the target has " + std::to_string(values) + " values for " + std::to_string(axes) + " axes"};
  }

 private:
  std::uint64_t epoch_;
  std::array<std::uint64_t, kUnderWay> requests_{};
  std::atomic<std::uint64_t> added_{0};
  std::atomic<std::uint64_t> complete_{0};
  std::atomic<std::uint64_t> done_{0};
};

}  // namespace driveline::motion
