#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace driveline::trajectory {

/// Two states of motion and the limits between them, as a frontier sees them: accelerations and velocities are divided
/// by the jerk limit, so that the acceleration changes by one per second. All four limits are magnitudes.
struct Boundary {
  double v0;      ///< velocity at the start
  double a0;      ///< acceleration at the start
  double v1;      ///< velocity at the end
  double a1;      ///< acceleration at the end
  double rise;    ///< largest acceleration
  double fall;    ///< largest deceleration
  double top;     ///< largest velocity forwards
  double bottom;  ///< largest velocity backwards

  /// The largest velocity that an acceleration leads to while it is taken back as fast as possible.
  [[nodiscard]] static double highest(double velocity, double acceleration) noexcept {
    return velocity + (acceleration > 0.0 ? acceleration * acceleration / 2.0 : 0.0);
  }
  /// The largest velocities, forwards and backwards, that the ends alone lead to or come from.
  [[nodiscard]] double least_top() const noexcept { return std::max(highest(v0, a0), highest(v1, -a1)); }
  [[nodiscard]] double least_bottom() const noexcept { return std::max(highest(-v0, -a0), highest(-v1, a1)); }
  /// The same ends with no more room for the velocity than they need.
  [[nodiscard]] Boundary narrowed() const noexcept {
    Boundary narrow = *this;
    narrow.top = least_top();
    narrow.bottom = least_bottom();
    return narrow;
  }
  /// The same motions with the axis turned round.
  [[nodiscard]] Boundary mirrored() const noexcept { return {-v0, -a0, -v1, -a1, fall, rise, bottom, top}; }
  /// The same motions as a film that runs backwards, with the axis turned round: velocities stay, accelerations do not.
  [[nodiscard]] Boundary reversed() const noexcept { return {v1, -a1, v0, -a0, fall, rise, top, bottom}; }
};

/// A stretch of constant jerk, divided by the jerk limit.
struct JerkPhase {
  double duration_s;
  double acceleration;  ///< at its begin
  double jerk;          ///< -1 to 1; with unlimited jerk 0
};

/// The phases of a motion without its start.
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
