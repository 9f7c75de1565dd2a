#pragma once

#include <cmath>
#include <utility>

#include "driveline/ecat_master/axis/axis.hpp"

namespace driveline::ecat_master {

/// Velocity of an axis without power: of one that its drive has not stopped, or that a load moves. It is switched on as
/// it moves, and braked within its limits; held at once, it would be stopped by all the torque of its drive.
///
/// Needs the velocity (606Ch) in the process data: without it every axis stands. A plain value; everything is \rtsafe.
class CoastWatch {
 public:
  /// `period_s`: of the line's cycle.
  CoastWatch(const AxisConfig& axis, double period_s) noexcept
      : max_velocity_(axis.limits.max_velocity), period_s_(period_s) {}

  /// The position (rad or m) and velocity of an exchange in this cycle.
  void look(double position, double velocity) noexcept {
    const double moved = std::abs(position - std::exchange(position_, position)) / period_s_;
    const double standing = kStanding * max_velocity_;
    velocity_ = moved > standing && std::abs(velocity) > standing ? velocity : 0.0;
  }
  /// The axis is not there.
  void forget() noexcept { velocity_ = 0.0; }

  /// rad/s or m/s; 0: it stands, whatever the filter of the velocity still says.
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// Whether it moves.
  [[nodiscard]] bool coasts() const noexcept { return std::abs(velocity_) > 0.0; }
  /// Whether it may be switched on: it is no faster than it may be, and `seen` in the last exchange. One that coasts is
  /// caught where it is, and not where it was when it was seen last.
  [[nodiscard]] bool catchable(bool seen) const noexcept {
    return std::abs(velocity_) <= max_velocity_ && (seen || !coasts());
  }
  /// The goal of an axis that is to be switched on; `steady`: its position is. One that coasts and may be on by what it
  /// was told goes on as it does, seen or not: told to switch off, and on again, it would get setpoints of a place that
  /// it has left. And one that was told to switch off may have done so since it was shown to be on.
  [[nodiscard]] cia402::Goal goal(const Axis& axis, bool steady, bool seen) const noexcept {
    const bool shown = axis.inputs().state == snapshot::AxisState::kOperationEnabled;
    const bool told = axis.told_on();
    const bool on = shown ? told || !coasts() : steady && catchable(seen || told);
    return on ? cia402::Goal::kEnabled : cia402::Goal::kDisabled;
  }

 private:
  /// Share of the highest velocity at which an axis counts as standing.
  static constexpr double kStanding = 2e-3;

  double max_velocity_;
  double period_s_;
  double position_ = 0.0;
  double velocity_ = 0.0;
};

}  // namespace driveline::ecat_master
