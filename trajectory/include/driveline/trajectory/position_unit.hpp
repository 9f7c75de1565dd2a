#pragma once

#include <span>
#include <string_view>

namespace driveline::trajectory {

/// Whether positions of an axis are angles or lengths.
enum class AxisKind {
  kRotary,  ///< rad
  kLinear,  ///< m
};

/// Returns "rad" or "m".
std::string_view si_unit(AxisKind kind) noexcept;

/// A unit in which positions of an axis are written and shown; velocities and accelerations append "/s" and "/s^2". All
/// calculations are in rad or m.
struct PositionUnit {
  std::string_view name;              ///< name as written, e.g. "mm"
  AxisKind kind = AxisKind::kRotary;  ///< kind of axes with this unit
  /// The unit is numerator / denominator rad or m. Dividing by 1000 is correctly rounded; multiplying by 0.001 is not.
  double numerator = 1.0;
  double denominator = 1.0;  ///< see numerator

  /// Converts a value in this unit to rad or m. \rtsafe
  [[nodiscard]] double to_si(double value) const noexcept { return value * numerator / denominator; }
  /// Converts a value in rad or m to this unit. \rtsafe
  [[nodiscard]] double from_si(double value) const noexcept { return value * denominator / numerator; }
};

/// All units: rad, deg, rev, m, mm, um, in this order.
[[nodiscard]] std::span<const PositionUnit> position_units() noexcept;
/// Finds the unit called `name`; valid until the program ends; null if there is none.
[[nodiscard]] const PositionUnit* find_position_unit(std::string_view name) noexcept;
/// Returns `unit`, or rad or m if it is null.
[[nodiscard]] const PositionUnit& unit_or_si(const PositionUnit* unit, AxisKind kind) noexcept;

}  // namespace driveline::trajectory
