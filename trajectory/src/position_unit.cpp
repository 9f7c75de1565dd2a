#include "driveline/trajectory/position_unit.hpp"

#include <algorithm>
#include <array>
#include <numbers>

namespace driveline::trajectory {
namespace {

constexpr std::array<PositionUnit, 6> kPositionUnits{{
    {"rad", AxisKind::kRotary, 1.0, 1.0},
    {"deg", AxisKind::kRotary, std::numbers::pi, 180.0},
    {"rev", AxisKind::kRotary, 2.0 * std::numbers::pi, 1.0},
    {"m", AxisKind::kLinear, 1.0, 1.0},
    {"mm", AxisKind::kLinear, 1.0, 1e3},
    {"um", AxisKind::kLinear, 1.0, 1e6},
}};

}  // namespace

std::string_view si_unit(AxisKind kind) noexcept {
  return kind == AxisKind::kRotary ? "rad" : "m";
}

std::span<const PositionUnit> position_units() noexcept {
  return kPositionUnits;
}

const PositionUnit* find_position_unit(std::string_view name) noexcept {
  const auto* const found = std::find_if(kPositionUnits.begin(), kPositionUnits.end(),
                                         [name](const PositionUnit& unit) { return unit.name == name; });
  return found == kPositionUnits.end() ? nullptr : found;
}

const PositionUnit& unit_or_si(const PositionUnit* unit, AxisKind kind) noexcept {
  return unit != nullptr ? *unit : *find_position_unit(si_unit(kind));
}

}  // namespace driveline::trajectory
