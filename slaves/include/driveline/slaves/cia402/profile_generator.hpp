#pragma once

#include <array>
#include <cstddef>

namespace driveline::slaves {

/// Limits of a movement, all positive and finite. `acceleration` applies while the magnitude of the speed increases,
/// `deceleration` while it decreases.
struct GeneratorLimits {
  double velocity = 1.0;      ///< maximum speed in units/s
  double acceleration = 1.0;  ///< in units/s^2
  double deceleration = 1.0;  ///< in units/s^2
  double jerk_time_s = 0.0;   ///< time in which the acceleration builds up; 0: trapezoidal (6086h = 0)

  friend bool operator==(const GeneratorLimits&, const GeneratorLimits&) = default;
};

/// State of a movement: position in the caller's unit (drive: increments or revolutions) and its time derivatives.
struct ProfileState {
  double position = 0.0;      ///< in units
  double velocity = 0.0;      ///< in units/s
  double acceleration = 0.0;  ///< in units/s^2
};

/// Profile generator of CiA 402: trapezoidal or jerk-limited movements to a position or to a speed, from any state of
/// motion. A movement is planned once, as phases of constant jerk, and then evaluated exactly, so that it ends exactly
/// on its target. A jerk time prolongs each acceleration phase by this time (P 166).
///
/// An initial acceleration beyond the limits is reduced to them first. A movement that reverses passes standstill with
/// zero acceleration.
class ProfileGenerator {
 public:
  /// Sets the state without a movement; a movement started before the next step() continues its acceleration. \rtsafe
  void reset(const ProfileState& state) noexcept;
  /// Starts a movement to standstill at `position`. \rtsafe
  void move_to(double position, const GeneratorLimits& limits) noexcept;
  /// Starts a movement that reaches `velocity` and keeps it. The velocity limit does not apply. \rtsafe
  void run_at(double velocity, const GeneratorLimits& limits) noexcept;
  /// \rtsafe
  void step(double step_s) noexcept;

  /// Returns the state after the last step(). \rtsafe
  [[nodiscard]] const ProfileState& state() const noexcept { return state_; }
  /// Whether the movement has ended: at standstill on the target, or at the target speed. \rtsafe
  [[nodiscard]] bool finished() const noexcept { return current_ == count_; }

 private:
  /// A phase of a movement with constant jerk.
  struct Phase {
    double duration_s = 0.0;
    double acceleration = 0.0;  ///< at the start of the phase
    double jerk = 0.0;
  };
  struct Plan;
  void follow(const Plan& plan, const ProfileState& target, bool ends_at_position) noexcept;
  void arrive() noexcept;

  static constexpr std::size_t kMaxPhases = 16;
  std::array<Phase, kMaxPhases> phases_{};
  std::size_t count_ = 0;
  std::size_t current_ = 0;
  double elapsed_s_ = 0.0;  ///< time since the start of the current phase
  ProfileState base_;       ///< state at the start of the current phase
  ProfileState state_;
  ProfileState target_;  ///< state at the end; the position is used only by move_to()
  bool ends_at_position_ = false;
};

}  // namespace driveline::slaves
