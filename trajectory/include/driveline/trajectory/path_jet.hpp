#pragma once

#include <cmath>
#include <numbers>

namespace driveline::trajectory {

/// A quantity along a path with its first three derivatives with respect to the length of the path. Arithmetic
/// propagates the derivatives by the product, quotient and chain rules, so a formula written once for the joint
/// positions also gives the exact motion of the joints.
struct PathJet {
  double value = 0.0;   ///< the quantity
  double first = 0.0;   ///< first derivative with respect to the length
  double second = 0.0;  ///< second derivative
  double third = 0.0;   ///< third derivative
};

/// \rtsafe
[[nodiscard]] constexpr PathJet operator+(const PathJet& a, const PathJet& b) noexcept {
  return {a.value + b.value, a.first + b.first, a.second + b.second, a.third + b.third};
}
/// \rtsafe
[[nodiscard]] constexpr PathJet operator+(const PathJet& a, double b) noexcept {
  return {a.value + b, a.first, a.second, a.third};
}
/// \rtsafe
[[nodiscard]] constexpr PathJet operator-(const PathJet& a) noexcept {
  return {-a.value, -a.first, -a.second, -a.third};
}
/// \rtsafe
[[nodiscard]] constexpr PathJet operator-(const PathJet& a, const PathJet& b) noexcept {
  return a + (-b);
}
/// \rtsafe
[[nodiscard]] constexpr PathJet operator*(const PathJet& a, double b) noexcept {
  return {a.value * b, a.first * b, a.second * b, a.third * b};
}
/// \rtsafe
[[nodiscard]] constexpr PathJet operator*(const PathJet& a, const PathJet& b) noexcept {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2.0 * a.first * b.first + a.value * b.second,
          a.third * b.value + 3.0 * (a.second * b.first + a.first * b.second) + a.value * b.third};
}

/// Square root of a positive quantity. \rtsafe
[[nodiscard]] inline PathJet sqrt(const PathJet& a) noexcept {
  // root^2 = a, differentiated three times.
  PathJet root;
  root.value = std::sqrt(a.value);
  const double half = 0.5 / root.value;
  root.first = a.first * half;
  root.second = (a.second - 2.0 * root.first * root.first) * half;
  root.third = (a.third - 6.0 * root.first * root.second) * half;
  return root;
}

/// Angle of a point other than the origin, from -pi to pi. \rtsafe
[[nodiscard]] inline PathJet atan2(const PathJet& y, const PathJet& x) noexcept {
  // angle' * (x^2 + y^2) = x y' - y x', differentiated twice.
  const PathJet square = x * x + y * y;
  const double turn = x.value * y.first - y.value * x.first;
  const double turn1 = x.value * y.second - y.value * x.second;
  const double turn2 = x.first * y.second - y.first * x.second + x.value * y.third - y.value * x.third;
  PathJet angle;
  angle.value = std::atan2(y.value, x.value);
  angle.first = turn / square.value;
  angle.second = (turn1 - angle.first * square.first) / square.value;
  angle.third = (turn2 - 2.0 * angle.second * square.first - angle.first * square.second) / square.value;
  return angle;
}

/// Wraps an angle to -pi (exclusive) to pi. \rtsafe
[[nodiscard]] inline PathJet within_half_turns(PathJet angle) noexcept {
  constexpr double kWhole = 2.0 * std::numbers::pi;
  if (angle.value > std::numbers::pi) angle.value -= kWhole;
  if (angle.value <= -std::numbers::pi) angle.value += kWhole;
  return angle;
}

}  // namespace driveline::trajectory
