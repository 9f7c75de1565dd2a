#pragma once

#include <cstdint>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Settings of a PositionTracker; rad or m.
struct TrackerSettings {
  double period_s = 125e-6;   ///< from step to step
  double cutoff_hz = 50.0;    ///< of both of its filters
  double noise = 0.0;         ///< by which positions are beside where the axis is, either way
  double max_velocity = 1.0;  ///< of the axis
  /// Steps without a measurement that are bridged; with more the axis is lost.
  std::uint32_t most_missing = 8;
};

/// Position, velocity and acceleration of something that is measured: an encoder, in every cycle or rarer.
///
/// * Two filters of third order, each with three equal poles at `cutoff_hz`. The first one estimates position, velocity
///   and acceleration from the measurements (a g-h-k filter with critical damping: E. Brookner, "Tracking and Kalman
///   Filtering Made Easy", 1998, chapter 2.5). The second one leads a point to what the first one has found by its
///   jerk, so what comes out has an acceleration without steps, whatever the grain of the encoder is. Neither is late
///   at a constant velocity or acceleration; a change of the acceleration is followed after about 1 / cutoff_hz.
/// * Standstill: what stays within +-`noise` for kStandingS stands, at the middle of what was measured. It moves when a
///   measurement is more than twice the noise away from there. So noise does not move it, and it does not creep.
/// * A missing measurement, and one that is farther from the last one than the axis can have gone, is bridged with the
///   velocity and acceleration of the estimate. More of them in a row than `most_missing`: it is lost, and begins anew
///   with the next measurement.
///
/// A plain value; everything is \rtsafe.
class PositionTracker {
 public:
  /// What stands must have stood for so long.
  static constexpr double kStandingS = 0.02;

  PositionTracker() = default;
  /// `period_s`, `cutoff_hz` and `max_velocity` positive, `noise` not negative. \rtsafe
  explicit PositionTracker(const TrackerSettings& settings) noexcept;

  /// A period later, with what was measured then. \rtsafe
  void step(double measured) noexcept;
  /// A period later, without a measurement that could be used. \rtsafe
  void step() noexcept;

  /// There are estimates: enough measurements have come, and the last ones. \rtsafe
  [[nodiscard]] bool valid() const noexcept { return state_ == State::kTracking; }
  /// It stands. \rtsafe
  [[nodiscard]] bool standing() const noexcept { return standing_; }
  /// Where it is so much later than the last step, in s, if its acceleration stays. \rtsafe
  [[nodiscard]] AxisSetpoint at(double later_s) const noexcept;
  /// Measurements that could not be. \rtsafe
  [[nodiscard]] std::uint64_t leaps() const noexcept { return leaps_; }

 private:
  enum class State : std::uint8_t { kLost, kSettling, kTracking };
  struct Motion {
    double position = 0.0;
    double velocity = 0.0;
    double acceleration = 0.0;
    void advance(double time_s, double jerk) noexcept;
  };

  void begin(double measured) noexcept;
  void correct(double measured) noexcept;
  void follow() noexcept;
  [[nodiscard]] double stood(double measured) noexcept;

  TrackerSettings settings_{};
  double g_ = 0.0;  ///< of the first filter
  double h_ = 0.0;
  double k_ = 0.0;
  double to_position_ = 0.0;  ///< gains of the second one
  double to_velocity_ = 0.0;
  double to_acceleration_ = 0.0;
  State state_ = State::kLost;
  std::uint32_t missing_ = 0;
  std::uint32_t settling_ = 0;  ///< steps left
  std::uint32_t settling_steps_ = 1;
  std::uint32_t standing_steps_ = 1;
  std::uint64_t leaps_ = 0;
  double last_ = 0.0;  ///< measured
  bool standing_ = false;
  double place_ = 0.0;   ///< where it stands
  double lowest_ = 0.0;  ///< of what may be a standstill
  double highest_ = 0.0;
  std::uint32_t still_ = 0;  ///< steps
  Motion estimate_{};
  Motion smooth_{};
};

}  // namespace driveline::trajectory
