#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// A range of positions, both ends included, in rad or m.
struct PositionRange {
  double min = 0.0;  ///< rad or m
  double max = 0.0;  ///< rad or m
};

/// The motion of one axis as a sequence of phases of constant jerk. Behind the last one the axis goes on at the
/// velocity of the end. Planners make it (plan_to_position, plan_to_velocity). A plain value.
class Profile {
 public:
  /// Four in which an axis comes back inside its limits, and up to thirteen for what follows.
  static constexpr std::size_t kMaxPhases = 17;

  /// A stretch of constant jerk: the state at its begin.
  struct Phase {
    double begin_s;       ///< since the begin of the profile
    double displacement;  ///< from the first position, rad or m
    double velocity;      ///< rad/s or m/s
    double acceleration;  ///< rad/s^2 or m/s^2
    double jerk;          ///< rad/s^3 or m/s^3
  };

  /// A motion at the given velocity that has no phase yet. \rtsafe
  explicit Profile(const AxisSetpoint& from = {}) noexcept;

  /// Adds a phase that starts at the given acceleration; one that does not last is left out, as is one too many.
  /// \rtsafe
  void append(double duration_s, double acceleration, double jerk) noexcept;
  /// Says what the last phase is to end in: the state from duration_s() on, without what was lost by rounding. \rtsafe
  void end_at(const AxisSetpoint& to) noexcept;
  /// The motion of another axis on a straight line: this one times a factor, between other ends. \rtsafe
  [[nodiscard]] Profile scaled(double factor, const AxisSetpoint& from, const AxisSetpoint& to) const noexcept;

  /// The setpoint at a time after the begin. Times before zero (and NaN) count as zero; behind the end the velocity of
  /// the end is kept, without acceleration. \rtsafe
  [[nodiscard]] AxisSetpoint evaluate(double elapsed_s) const noexcept;

  /// \rtsafe
  [[nodiscard]] bool finished(double elapsed_s) const noexcept { return elapsed_s >= duration_s_; }
  /// \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return duration_s_; }
  /// The state in which the last phase ends. \rtsafe
  [[nodiscard]] const AxisSetpoint& end() const noexcept { return end_; }
  /// \rtsafe
  [[nodiscard]] std::span<const Phase> phases() const noexcept { return {phases_.data(), count_}; }
  /// The smallest and the largest position from begin to end, not only at the ends of phases. \rtsafe
  [[nodiscard]] PositionRange extremes() const noexcept;

 private:
  std::array<Phase, kMaxPhases> phases_;
  std::size_t count_ = 0;
  double duration_s_ = 0.0;
  double start_position_;
  double end_displacement_ = 0.0;
  AxisSetpoint end_;
};

/// Whether a profile stays within a range of positions on its whole way, its end included; what comes behind the end
/// does not count. \rtsafe
[[nodiscard]] bool fits(const Profile& profile, const PositionRange& range) noexcept;

}  // namespace driveline::trajectory
