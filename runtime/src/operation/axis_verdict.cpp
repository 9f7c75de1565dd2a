#include "operation/axis_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "operation/motion_text.hpp"

namespace driveline::runtime {
namespace {

/// Uncertainty of the time between a setpoint and the position it is compared with: two exchanges, at least this.
constexpr std::chrono::milliseconds kUnsureTime{5};

std::string off_by(const ecat_master::AxisConfig& axis, double error, double tolerance, bool increments) {
  const auto& unit = ecat_master::position_unit(axis);
  return fmt::format(
      "axis {}: ended {} away from its setpoint, {:.3g} {} are tolerated (position_tolerance): it did not follow its "
      "path",
      axis.name, length_text(axis, std::abs(error), increments), unit.from_si(tolerance), unit.name);
}

}  // namespace

std::string axis_verdict(const ecat_master::AxisConfig& axis, const FollowingError& seen,
                         std::chrono::nanoseconds period, bool increments) {
  if (!seen.last || seen.last->state == snapshot::AxisState::kUnavailable) return {};
  if (seen.samples == 0) {
    return fmt::format("axis {}: never was in Operation enabled, status word 0x{:04X} ({}) at the end", axis.name,
                       seen.last->status_word, ecat_master::cia402::to_text(seen.last->state));
  }
  const double allowed = ecat_master::position_tolerance(axis);
  if (seen.last->state != snapshot::AxisState::kOperationEnabled || !(allowed > 0.0)) return {};
  const auto unsure = std::max<std::chrono::nanoseconds>(kUnsureTime, 2 * period);
  const double tolerance =
      allowed + std::abs(seen.last->target_velocity) * std::chrono::duration<double>(unsure).count();
  const double error = seen.last->following_error;
  // Written so that NaN counts as off.
  return std::abs(error) <= tolerance ? std::string{} : off_by(axis, error, tolerance, increments);
}

}  // namespace driveline::runtime
