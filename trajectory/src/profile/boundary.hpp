#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace driveline::trajectory {

/// Two states of motion and the limits between them, in the units of a frontier: accelerations and velocities are
/// divided by the jerk limit, so that the acceleration changes by one per second. All four limits are magnitudes.
struct Boundary {
  double v0;      ///< velocity at the start
  double a0;      ///< acceleration at the start
  double v1;      ///< velocity at the end
  double a1;      ///< acceleration at the end
  double rise;    ///< largest acceleration
  double fall;    ///< largest deceleration
  double top;     ///< largest velocity forwards
  double bottom;  ///< largest velocity backwards

  /// The velocity reached if an acceleration is reduced to zero as fast as possible.
  [[nodiscard]] static double highest(double velocity, double acceleration) noexcept {
    return velocity + (acceleration > 0.0 ? acceleration * acceleration / 2.0 : 0.0);
  }
  /// The smallest possible velocity limits, forwards and backwards, for these end states.
  [[nodiscard]] double least_top() const noexcept { return std::max(highest(v0, a0), highest(v1, -a1)); }
  [[nodiscard]] double least_bottom() const noexcept { return std::max(highest(-v0, -a0), highest(-v1, a1)); }
  /// The same end states with the smallest possible velocity limits.
  [[nodiscard]] Boundary narrowed() const noexcept {
    Boundary narrow = *this;
    narrow.top = least_top();
    narrow.bottom = least_bottom();
    return narrow;
  }
  /// The same motions with the axis inverted.
  [[nodiscard]] Boundary mirrored() const noexcept { return {-v0, -a0, -v1, -a1, fall, rise, bottom, top}; }
  /// The same motions reversed in time with the axis inverted: velocities stay, accelerations change sign.
  [[nodiscard]] Boundary reversed() const noexcept { return {v1, -a1, v0, -a0, fall, rise, top, bottom}; }
};

/// A phase of constant jerk, divided by the jerk limit.
struct JerkPhase {
  double duration_s;
  double acceleration;  ///< acceleration at its start
  double jerk;          ///< -1 to 1; 0 with unlimited jerk
};

/// The phases of a motion without its start state.
class PhaseList {
 public:
  void push(double duration_s, double acceleration, double jerk) noexcept {
    if (duration_s > 0.0 && count_ < phases_.size()) {
      phases_[count_++] = {duration_s, acceleration, jerk};
    }
  }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] const JerkPhase& operator[](std::size_t i) const noexcept { return phases_[i]; }
  [[nodiscard]] const JerkPhase* begin() const noexcept { return phases_.data(); }
  [[nodiscard]] const JerkPhase* end() const noexcept { return phases_.data() + count_; }

 private:
  std::array<JerkPhase, 7> phases_;
  std::size_t count_ = 0;
};

}  // namespace driveline::trajectory
