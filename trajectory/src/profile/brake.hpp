#pragma once

#include "boundary.hpp"

namespace driveline::trajectory {

/// The motion of an axis back inside its limits, and the state after it. Units as in Boundary.
struct Brake {
  PhaseList phases;
  double velocity;
  double acceleration;
};

/// Relative excess over a limit up to which an axis is not brought back: rounding of a state at the limit.
inline constexpr double kRounding = 1e-12;

/// Brings only the acceleration back inside its limits, as fast as possible.
[[nodiscard]] Brake brake_acceleration(double velocity, double acceleration, double rise, double fall) noexcept;

/// Brings a state inside the limits of a boundary, to a point from which it need not leave them, as fast as possible:
/// first the acceleration, then the velocity. The end states of the boundary are ignored.
[[nodiscard]] Brake brake_with_jerk(double velocity, double acceleration, const Boundary& limits) noexcept;

/// Like brake_with_jerk(), with unlimited jerk.
[[nodiscard]] Brake brake_at_once(double velocity, const Boundary& limits) noexcept;

}  // namespace driveline::trajectory
