#pragma once

#include "driveline/slaves/cia402/profile_generator.hpp"
#include "driveline/slaves/position_servo/move.hpp"

namespace driveline::slaves::position_servo {

/// One segment of a continuous profile: from a position and velocity to a position and velocity. The acceleration
/// follows from both velocities and the length (lines 4036-4045): a = (v1^2 - v0^2) / (2 d), in 2 d / (v0 + v1).
/// An S-curve takes the same time, and its acceleration rises to 2 a and falls back to 0.
class Segment {
 public:
  /// Plans the segment from `start` (counts, counts/s; the acceleration is ignored) to `target` in counts, with the
  /// velocity of `move` at its end. Returns kNone, or why no such motion exists; then the segment is unchanged. \rtsafe
  [[nodiscard]] MotionFault plan(const ProfileState& start, double target, const Move& move) noexcept;

  /// Returns the state `elapsed_s` after the start; from duration_s() on exactly the end. \rtsafe
  [[nodiscard]] ProfileState at(double elapsed_s) const noexcept;
  /// Returns the duration in s; 0 if the segment has no length. \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return duration_s_; }
  /// Returns the state at the end, without acceleration. \rtsafe
  [[nodiscard]] ProfileState end() const noexcept { return end_; }

 private:
  ProfileState start_;
  ProfileState end_;
  double duration_s_ = 0.0;
  bool s_curve_ = false;
};

}  // namespace driveline::slaves::position_servo
