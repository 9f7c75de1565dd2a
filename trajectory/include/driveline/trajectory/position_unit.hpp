#pragma once

#include <span>
#include <string_view>

namespace driveline::trajectory {

/// Tells which SI unit an axis is in.
enum class AxisKind {
  kRotary,  ///< rad
  kLinear,  ///< m
};

/// "rad" or "m".
std::string_view si_unit(AxisKind kind) noexcept;

/// A unit in which people write and read positions of an axis, and with "/s" and "/s^2" its velocities and
/// accelerations. Everything is calculated in rad or m.
struct PositionUnit {
  std::string_view name;              ///< as it is written: "mm"
  AxisKind kind = AxisKind::kRotary;  ///< of the axes that can be in it
  /// It is numerator / denominator rad or m. Dividing by 1000 is correctly rounded where multiplying by 0.001 is not.
  double numerator = 1.0;
  double denominator = 1.0;  ///< see numerator

  /// A value in this unit, in rad or m. \rtsafe
  [[nodiscard]] double to_si(double value) const noexcept { return value * numerator / denominator; }
  /// A value in rad or m, in this unit. \rtsafe
  [[nodiscard]] double from_si(double value) const noexcept { return value * denominator / numerator; }
};

/// rad, deg, rev, m, mm, um, in this order.
[[nodiscard]] std::span<const PositionUnit> position_units() noexcept;
/// Null: there is none of that name. Lives as long as the program.
[[nodiscard]] const PositionUnit* find_position_unit(std::string_view name) noexcept;
/// `unit`, or rad or m when it is null.
[[nodiscard]] const PositionUnit& unit_or_si(const PositionUnit* unit, AxisKind kind) noexcept;

}  // namespace driveline::trajectory
