#pragma once

#include <cmath>
#include <utility>

#include "driveline/motion/axis/axis.hpp"

namespace driveline::motion {

/// Velocity of an axis without power that its drive has not stopped, or that a load moves. Such an axis is switched on
/// while it moves and then braked within its limits; holding it at once would stop it with the full torque of its
/// drive.
///
/// Needs the velocity (606Ch) in the process data: without it every axis counts as standing. A plain value; everything
/// is \rtsafe.
class CoastWatch {
 public:
  /// `period_s`: cycle time of the line.
  CoastWatch(const AxisConfig& axis, double period_s) noexcept
      : max_velocity_(axis.limits.max_velocity), period_s_(period_s) {}

  /// Takes the position (rad or m) and velocity (rad/s or m/s) of an exchange in this cycle.
  void update(double position, double velocity) noexcept {
    const double moved = std::abs(position - std::exchange(position_, position)) / period_s_;
    const double standing = kStanding * max_velocity_;
    velocity_ = moved > standing && std::abs(velocity) > standing ? velocity : 0.0;
  }
  /// Forgets the velocity, because the axis is not available.
  void forget() noexcept { velocity_ = 0.0; }

  /// rad/s or m/s; 0: the axis is at standstill, even if the filtered velocity is not zero yet.
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// Whether the axis moves.
  [[nodiscard]] bool coasts() const noexcept { return std::abs(velocity_) > 0.0; }
  /// Whether the axis may be switched on: it is not above its velocity limit, and if it coasts it was `seen` in the
  /// last exchange, so that it is caught at its present position and not at an old one.
  [[nodiscard]] bool catchable(bool seen) const noexcept {
    return std::abs(velocity_) <= max_velocity_ && (seen || !coasts());
  }
  /// Goal of an axis to be switched on; `steady`: its position is steady. A coasting axis that may already be on,
  /// because it was commanded so, keeps that command whether it is seen or not: switched off and on again, it would get
  /// setpoints of a position that it has left. A coasting axis that was commanded off may have switched off since it
  /// was shown to be on.
  [[nodiscard]] cia402::Goal goal(const Axis& axis, bool steady, bool seen) const noexcept {
    const bool shown = axis.inputs().state == snapshot::AxisState::kOperationEnabled;
    const bool commanded = axis.commanded_on();
    const bool on = shown ? commanded || !coasts() : steady && catchable(seen || commanded);
    return on ? cia402::Goal::kEnabled : cia402::Goal::kDisabled;
  }

 private:
  /// Share of max_velocity below which an axis counts as standing.
  static constexpr double kStanding = 2e-3;

  double max_velocity_;
  double period_s_;
  double position_ = 0.0;
  double velocity_ = 0.0;
};

}  // namespace driveline::motion
