#pragma once

#include <bit>
#include <cstdint>

namespace driveline::trajectory {

/// A torque (Nm) or force (N) that may be left out, in the size of a double: the setpoints of all axes pass through
/// every cycle, and std::optional<double> would take twice as much. \rtsafe
class OptionalTorque {
 public:
  /// None.
  constexpr OptionalTorque() noexcept = default;
  /// Any number, and NaN as well: a source that has calculated one has given a torque, if a wrong one.
  constexpr OptionalTorque(double value) noexcept : value_(value) {}  // NOLINT(google-explicit-constructor): a setpoint in braces

  /// There is one.
  [[nodiscard]] constexpr bool has_value() const noexcept { return std::bit_cast<std::uint64_t>(value_) != kNone; }
  /// The same.
  [[nodiscard]] constexpr explicit operator bool() const noexcept { return has_value(); }
  /// Precondition: has_value().
  [[nodiscard]] constexpr double operator*() const noexcept { return value_; }
  /// The torque, or `otherwise` where there is none.
  [[nodiscard]] constexpr double value_or(double otherwise) const noexcept { return has_value() ? value_ : otherwise; }

 private:
  /// A signalling NaN: no calculation has it as its result (IEEE 754-2008, 6.2).
  static constexpr std::uint64_t kNone = 0x7FF0'0000'0000'0D1E;

  double value_ = std::bit_cast<double>(kNone);
};

}  // namespace driveline::trajectory
