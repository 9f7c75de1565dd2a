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

/// The motion of an axis as a sequence of phases of constant jerk. After the last phase the axis continues at the end
/// velocity. Created by planners (plan_to_position, plan_to_velocity). A plain value.
class Profile {
 public:
  /// Four phases to bring an axis back inside its limits, and up to thirteen for the remaining motion.
  static constexpr std::size_t kMaxPhases = 17;

  /// A phase of constant jerk with the state at its start.
  struct Phase {
    double begin_s;       ///< time since the start of the profile
    double displacement;  ///< displacement from the first position, rad or m
    double velocity;      ///< rad/s or m/s
    double acceleration;  ///< rad/s^2 or m/s^2
    double jerk;          ///< rad/s^3 or m/s^3
  };

  /// Creates a motion without phases that starts at `from`. \rtsafe
  explicit Profile(const AxisSetpoint& from = {}) noexcept;

  /// Adds a phase that starts at the given acceleration. A phase without duration, or beyond kMaxPhases, is ignored.
  /// \rtsafe
  void append(double duration_s, double acceleration, double jerk) noexcept;
  /// Sets the exact state at the end of the last phase, which replaces the result with its rounding errors. \rtsafe
  void end_at(const AxisSetpoint& to) noexcept;
  /// Returns the motion of another axis on a straight line: this motion times `factor`, between other end states.
  /// \rtsafe
  [[nodiscard]] Profile scaled(double factor, const AxisSetpoint& from, const AxisSetpoint& to) const noexcept;

  /// Returns the setpoint at a time after the start. Times before zero (and NaN) count as zero; after the end the end
  /// velocity continues without acceleration. \rtsafe
  [[nodiscard]] AxisSetpoint evaluate(double elapsed_s) const noexcept;

  /// Whether the phases end at this position, apart from rounding: to plan with limits of extreme ratios may lose a
  /// phase to an overflow. \rtsafe
  [[nodiscard]] bool arrives_at(double position) const noexcept;

  /// Whether the end has been reached. \rtsafe
  [[nodiscard]] bool finished(double elapsed_s) const noexcept { return elapsed_s >= duration_s_; }
  /// Duration of all phases. \rtsafe
  [[nodiscard]] double duration_s() const noexcept { return duration_s_; }
  /// State at the end of the last phase. \rtsafe
  [[nodiscard]] const AxisSetpoint& end() const noexcept { return end_; }
  /// The phases in order of time. \rtsafe
  [[nodiscard]] std::span<const Phase> phases() const noexcept { return {phases_.data(), count_}; }
  /// Smallest and largest position from start to end, inside the phases as well. \rtsafe
  [[nodiscard]] PositionRange extremes() const noexcept;

 private:
  std::array<Phase, kMaxPhases> phases_;
  std::size_t count_ = 0;
  double duration_s_ = 0.0;
  double start_position_;
  double end_displacement_ = 0.0;
  AxisSetpoint end_;
};

/// Whether a profile stays within a range of positions from start to end; the motion after the end does not count.
/// \rtsafe
[[nodiscard]] bool fits(const Profile& profile, const PositionRange& range) noexcept;

}  // namespace driveline::trajectory
