#pragma once

#include <bit>
#include <cstdint>

namespace driveline::trajectory {

/// An optional torque (Nm) or force (N) of the size of a double: the setpoints of all axes are copied in every cycle,
/// and std::optional<double> is twice as large. \rtsafe
class OptionalTorque {
 public:
  /// No torque.
  constexpr OptionalTorque() noexcept = default;
  /// Any number, also NaN: a source that computes NaN has given a torque, although a wrong one.
  // NOLINTNEXTLINE(google-explicit-constructor): setpoints are written in braces
  constexpr OptionalTorque(double value) noexcept : value_(value) {}

  /// Whether there is a torque.
  [[nodiscard]] constexpr bool has_value() const noexcept { return std::bit_cast<std::uint64_t>(value_) != kNone; }
  /// Same as has_value().
  [[nodiscard]] constexpr explicit operator bool() const noexcept { return has_value(); }
  /// Precondition: has_value().
  [[nodiscard]] constexpr double operator*() const noexcept { return value_; }
  /// The torque, or `otherwise` if there is none.
  [[nodiscard]] constexpr double value_or(double otherwise) const noexcept { return has_value() ? value_ : otherwise; }

 private:
  /// A signalling NaN, which no calculation produces (IEEE 754-2008, 6.2).
  static constexpr std::uint64_t kNone = 0x7FF0'0000'0000'0D1E;

  double value_ = std::bit_cast<double>(kNone);
};

}  // namespace driveline::trajectory
