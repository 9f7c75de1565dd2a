#include "operation/motion_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace driveline::runtime {

std::string length_text(const ecat_master::AxisConfig& axis, double length, bool increments) {
  const auto& unit = ecat_master::position_unit(axis);
  auto text = fmt::format("{:.5g} {}", unit.from_si(length), unit.name);
  if (increments) text += fmt::format(" ({:.0f} increments)", length * axis.increments_per_unit);
  return text;
}

std::string describe_position(const ecat_master::AxisConfig& axis, const ecat_master::MotionFailure& failure,
                              bool increments) {
  using Cause = ecat_master::MotionFailure::Cause;
  const auto& found = failure.position;
  const auto& unit = ecat_master::position_unit(axis);
  const auto way = [&](double length) { return length_text(axis, length, increments); };
  const double ms = found.within_s * 1e3;
  if (failure.cause == Cause::kPositionFrozen) {
    return fmt::format(
        "axis {}: its actual position stood at {:.6g} {} for {:.4g} ms while it was sent {} on: frozen, or the axis is "
        "blocked; all axes stopped within their limits",
        axis.name, unit.from_si(found.from), unit.name, ms, way(found.moved));
  }
  const auto leap = fmt::format("leapt by {} within {:.4g} ms, {:.3g} {} are possible", way(found.moved), ms,
                                unit.from_si(found.allowed), unit.name);
  if (failure.cause == Cause::kPositionLeap) {
    return fmt::format("axis {}: its actual position {}: not plausible; all axes stopped within their limits",
                       axis.name, leap);
  }
  return fmt::format("axis {}: was not enabled, its actual position is not steady: it {}", axis.name, leap);
}

}  // namespace driveline::runtime
