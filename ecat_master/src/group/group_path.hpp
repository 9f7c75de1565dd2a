#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "driveline/ecat_master/group/group_request.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// A path of a group: planned by one thread, followed by the cycle meanwhile. It begins where the axes stand, and goes
/// on as long as moves come; a stop for good ends it.
class GroupPath {
 public:
  /// Moves that are planned and not done yet.
  static constexpr std::size_t kUnderWay = 1024;

  /// Where the axes are on it.
  struct Place {
    std::uint64_t move = 0;  ///< number of the move, 0 is the first
    double length = 0.0;     ///< since the begin, m or rad
    double speed = 0.0;      ///< m/s or rad/s, negative backwards
    bool at_rest = true;     ///< all axes stand
    bool at_end = true;      ///< at the end of what is planned, in the direction that is asked for
  };

  virtual ~GroupPath() = default;
  GroupPath(const GroupPath&) = delete;
  GroupPath& operator=(const GroupPath&) = delete;

  /// Number of the place where it begins: AxisGroup::Standing.
  [[nodiscard]] std::uint64_t epoch() const noexcept { return epoch_; }

  // Planning.
  /// There is room for another move.
  [[nodiscard]] bool has_room() const noexcept {
    return added_.load(std::memory_order_relaxed) - done_.load(std::memory_order_acquire) < kUnderWay;
  }
  /// Adds a move, whose places are absolute; a sentence if that cannot be. The cycle sees it after flush().
  [[nodiscard]] virtual tl::expected<void, trajectory::PathMoveError> add(const GroupMove& move) = 0;
  /// The move that was added last belongs to that request. Before flush().
  void note(std::uint64_t request) noexcept {
    const auto added = added_.load(std::memory_order_relaxed);
    requests_[added % kUnderWay] = request;
    added_.store(added + 1, std::memory_order_release);
  }
  /// The axes stop behind the last move.
  virtual void finish() = 0;
  /// Hands over what has been planned; false: again later.
  [[nodiscard]] virtual bool flush() = 0;
  /// After finish(), when flush() was true: all moves are done at the end of what is planned.
  void complete() noexcept { complete_.store(added_.load(std::memory_order_relaxed), std::memory_order_release); }
  /// All moves that were added have been completed, and are done.
  [[nodiscard]] bool idle() const noexcept { return done_.load(std::memory_order_acquire) == added_; }
  /// Where the last move ends, a value for each axis.
  [[nodiscard]] virtual std::span<const double> target() const noexcept = 0;
  /// Requests of moves that the cycle has not settled any more, when it has given the path back.
  template <typename Each>
  void unsettled(Each&& each) const {
    for (auto move = done_.load(std::memory_order_relaxed); move < added_.load(std::memory_order_relaxed); ++move)
      each(requests_[move % kUnderWay]);
  }

  // The cycle. \rtsafe
  /// See trajectory::ContourFollower. \rtsafe
  virtual void set_override(double share) noexcept = 0;
  virtual void hold(bool held) noexcept = 0;
  virtual void reverse(bool backwards) noexcept = 0;
  /// The next cycle. \rtsafe
  virtual Place step(std::span<trajectory::AxisSetpoint> setpoints) noexcept = 0;

  /// Moves up to that are done at the end of what is planned; to be asked before step(). \rtsafe
  [[nodiscard]] std::uint64_t completed() const noexcept { return complete_.load(std::memory_order_acquire); }
  /// Request of the next move that is not done; 0: there is none. \rtsafe
  [[nodiscard]] std::uint64_t next_request() const noexcept {
    const auto done = done_.load(std::memory_order_relaxed);
    return done < added_.load(std::memory_order_acquire) ? requests_[done % kUnderWay] : 0;
  }
  /// Number of the next move that is not done. \rtsafe
  [[nodiscard]] std::uint64_t done() const noexcept { return done_.load(std::memory_order_relaxed); }
  /// That one is done, or will never be. \rtsafe
  void settle_one() noexcept { done_.store(done_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  /// Request of a move that is not done. \rtsafe
  [[nodiscard]] std::uint64_t request_of(std::uint64_t move) const noexcept { return requests_[move % kUnderWay]; }

 protected:
  explicit GroupPath(std::uint64_t epoch) noexcept : epoch_(epoch) {}
  /// Of a target with that many values.
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

}  // namespace driveline::ecat_master
