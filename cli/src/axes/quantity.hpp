#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "driveline/motion/axis/axis.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// The kind of a number: a position or one of its derivatives, or a torque or its rate.
enum class Quantity : std::uint8_t { kPosition, kVelocity, kAcceleration, kJerk, kTorque, kTorqueRate };

/// Parses "90deg", "30 deg/s" or, in the unit of the axis, "90" into SI units: rad or m, Nm or N, per s. Failure:
/// status 2, names `what`.
[[nodiscard]] Outcome<double> parse_quantity(const motion::AxisConfig& axis, Quantity quantity, std::string_view text,
                                             std::string_view what);

/// Whether the text is a unit of any quantity of the axis.
[[nodiscard]] bool is_unit(const motion::AxisConfig& axis, std::string_view text);

/// A number at the beginning of a text, and the text after it.
struct LeadingNumber {
  double value = 0.0;
  std::string_view rest;
};
/// None: the text does not start with a finite number.
[[nodiscard]] std::optional<LeadingNumber> leading_number(std::string_view text);

/// Parses "2s", "500ms" or, in seconds, "2"; 0 to 10000000 s. Failure: status 2, names `what`.
[[nodiscard]] Outcome<std::chrono::nanoseconds> parse_time(std::string_view text, std::string_view what);

}  // namespace driveline::cli
