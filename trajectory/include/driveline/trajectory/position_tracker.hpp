#pragma once

#include <cstdint>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Settings of a PositionTracker; rad or m.
struct TrackerSettings {
  double period_s = 125e-6;   ///< time between steps
  double cutoff_hz = 50.0;    ///< cut-off frequency of both filters
  double noise = 0.0;         ///< largest deviation of a measurement from the true position, +-
  double max_velocity = 1.0;  ///< largest velocity of the axis, rad/s or m/s
  /// Number of steps without a measurement that are bridged; with more the axis is lost.
  std::uint32_t most_missing = 8;
};

/// Estimates position, velocity and acceleration of a measured object, such as an encoder, measured in every cycle or
/// less often.
///
/// * Two third-order filters, each with three equal poles at `cutoff_hz`. The first filter estimates position, velocity
///   and acceleration from the measurements (a g-h-k filter with critical damping: E. Brookner, "Tracking and Kalman
///   Filtering Made Easy", 1998, chapter 2.5). The second filter moves a point towards this estimate by its jerk, so
///   that the output has an acceleration without steps, whatever the resolution of the encoder is. Neither has a lag at
///   constant velocity or acceleration; a change of the acceleration is followed after about 1 / cutoff_hz.
/// * Standstill: an object that stays within +-`noise` for kStandingS is at standstill, at the middle of the measured
///   range. It moves again when a measurement is more than twice the noise away from there. So noise does not move it,
///   and it does not creep.
/// * A missing measurement, or a measurement farther from the last one than the axis can have moved, is bridged with
///   the estimated velocity and acceleration. After more than `most_missing` of them in a row the object is lost, and
///   the tracker restarts with the next measurement.
///
/// A plain value; everything is \rtsafe.
class PositionTracker {
 public:
  /// Time without motion after which the object counts as standing still.
  static constexpr double kStandingS = 0.02;

  PositionTracker() = default;
  /// Requires positive `period_s`, `cutoff_hz` and `max_velocity`, and `noise` >= 0. \rtsafe
  explicit PositionTracker(const TrackerSettings& settings) noexcept;

  /// Advances by one period with the position `measured` at its end. \rtsafe
  void step(double measured) noexcept;
  /// Advances by one period without a usable measurement. \rtsafe
  void step() noexcept;

  /// Whether there are estimates: the tracker has settled and few recent measurements are missing. \rtsafe
  [[nodiscard]] bool valid() const noexcept { return state_ == State::kTracking; }
  /// Whether the object stands still. \rtsafe
  [[nodiscard]] bool standing() const noexcept { return standing_; }
  /// Estimated state `later_s` seconds after the last step, at constant acceleration. \rtsafe
  [[nodiscard]] AxisSetpoint at(double later_s) const noexcept;
  /// Number of measurements rejected as impossible. \rtsafe
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
  double g_ = 0.0;  ///< position gain of the first filter
  double h_ = 0.0;
  double k_ = 0.0;
  double to_position_ = 0.0;  ///< gains of the second filter
  double to_velocity_ = 0.0;
  double to_acceleration_ = 0.0;
  State state_ = State::kLost;
  std::uint32_t missing_ = 0;
  std::uint32_t settling_ = 0;  ///< remaining steps of settling
  std::uint32_t settling_steps_ = 1;
  std::uint32_t standing_steps_ = 1;
  std::uint64_t leaps_ = 0;
  double last_ = 0.0;  ///< last measurement
  bool standing_ = false;
  double place_ = 0.0;   ///< position of the standstill
  double lowest_ = 0.0;  ///< lower end of a possible standstill
  double highest_ = 0.0;
  std::uint32_t still_ = 0;  ///< steps within that range
  Motion estimate_{};
  Motion smooth_{};
};

}  // namespace driveline::trajectory
