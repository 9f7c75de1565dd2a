#pragma once

#include <array>
#include <cstddef>

namespace driveline::slaves {

/// Limits of one movement. Everything positive and finite; `acceleration` counts while the speed grows in magnitude,
/// `deceleration` while it falls.
struct ProfileLimits {
  double velocity = 1.0;      ///< greatest speed on the way, units of position per s
  double acceleration = 1.0;  ///< in units/s^2
  double deceleration = 1.0;  ///< in units/s^2
  double jerk_time_s = 0.0;   ///< time in which the acceleration builds up; 0: trapezoid (6086h = 0)

  friend bool operator==(const ProfileLimits&, const ProfileLimits&) = default;
};

/// State of a movement in the caller's unit of position (the drive: increments or revolutions) and its time
/// derivatives.
struct ProfileState {
  double position = 0.0;      ///< in units
  double velocity = 0.0;      ///< in units/s
  double acceleration = 0.0;  ///< in units/s^2
};

/// Profile generator of CiA 402: trapezoidal or jerk-limited movements to a position or to a speed, from any state of
/// motion. A movement is planned once, as phases of constant jerk, and then evaluated exactly, so it ends on its
/// target to the last bit. With a jerk time the phases of acceleration get longer by it (P 166).
///
/// From a state of acceleration that the limits do not allow, the acceleration is brought into them first. A movement
/// that has to turn round passes standstill without acceleration.
class ProfileGenerator {
 public:
  /// Sets the state without a movement; a movement that begins before the next step() takes over its acceleration.
  /// \rtsafe
  void reset(const ProfileState& state) noexcept;
  /// To `position` and standstill there. \rtsafe
  void move_to(double position, const ProfileLimits& limits) noexcept;
  /// To `velocity`, and on with it. The velocity limit does not count here. \rtsafe
  void run_at(double velocity, const ProfileLimits& limits) noexcept;
  /// \rtsafe
  void step(double step_s) noexcept;

  /// State after the last step(). \rtsafe
  [[nodiscard]] const ProfileState& state() const noexcept { return state_; }
  /// The movement has come to its end: standing on the target, or running at the speed. \rtsafe
  [[nodiscard]] bool finished() const noexcept { return current_ == count_; }

 private:
  /// A part of a movement with constant jerk.
  struct Phase {
    double duration_s = 0.0;
    double acceleration = 0.0;  ///< at its beginning
    double jerk = 0.0;
  };
  struct Plan;
  void follow(const Plan& plan, const ProfileState& target, bool ends_at_position) noexcept;
  void arrive() noexcept;

  static constexpr std::size_t kMaxPhases = 16;
  std::array<Phase, kMaxPhases> phases_{};
  std::size_t count_ = 0;
  std::size_t current_ = 0;
  double elapsed_s_ = 0.0;  ///< in the current phase
  ProfileState base_;       ///< at the beginning of the current phase
  ProfileState state_;
  ProfileState target_;  ///< state at the end; the position only counts for move_to()
  bool ends_at_position_ = false;
};

}  // namespace driveline::slaves
