#pragma once

#include "boundary.hpp"

namespace driveline::trajectory {

/// The way of an axis back inside its limits, and where it is then. Units as in Boundary.
struct Brake {
  PhaseList phases;
  double velocity;
  double acceleration;
};

/// How far a limit may be exceeded before an axis is brought back: what rounding does to a state that is at the limit.
inline constexpr double kRounding = 1e-12;

/// Brings the acceleration back inside its limits as fast as possible, and nothing else.
[[nodiscard]] Brake brake_acceleration(double velocity, double acceleration, double rise, double fall) noexcept;

/// Brings a state to where it neither is outside the limits of a boundary nor must leave them, as fast as possible:
/// first the acceleration, then the velocity. Ends of the boundary do not count.
[[nodiscard]] Brake brake_with_jerk(double velocity, double acceleration, const Boundary& limits) noexcept;

/// The same with unlimited jerk.
[[nodiscard]] Brake brake_at_once(double velocity, const Boundary& limits) noexcept;

}  // namespace driveline::trajectory
