#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "driveline/ecat_master/axis/axis.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// What a number is: an order of the derivative of a position, or a torque.
enum class Quantity : std::uint8_t { kPosition, kVelocity, kAcceleration, kJerk, kTorque, kTorqueRate };

/// "90deg", "30 deg/s" or "90", which is in the unit of the axis, in SI units: rad or m, Nm or N, per s. Failure:
/// status 2, names `what`.
[[nodiscard]] Outcome<double> parse_quantity(const ecat_master::AxisConfig& axis, Quantity quantity,
                                             std::string_view text, std::string_view what);

/// A number at the beginning of a text, and what stands behind it.
struct LeadingNumber {
  double value = 0.0;
  std::string_view rest;
};
/// None: the text begins with no number, or one that is not finite.
[[nodiscard]] std::optional<LeadingNumber> leading_number(std::string_view text);

/// "2s", "500ms" or "2", which are seconds; 0 to 10000000 s. Failure: status 2, names `what`.
[[nodiscard]] Outcome<std::chrono::nanoseconds> parse_time(std::string_view text, std::string_view what);

}  // namespace driveline::cli
