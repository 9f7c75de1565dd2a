#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace driveline::trajectory {

/// Interpolation between the points of a path.
enum class InterpolationMethod : std::uint8_t {
  kHold,           ///< each point is held until the next
  kLinear,         ///< straight lines
  kHermite,        ///< cubics with given or estimated velocity at each point
  kNaturalSpline,  ///< cubic spline with free ends
  kClampedSpline,  ///< cubic spline with given velocities at the ends, by default standstill
  kQuintic,        ///< fifth degree, with given or estimated velocity and acceleration at each point
  kCosine,         ///< half a period of a cosine between two points, at standstill at each
  kBSpline,        ///< cubic B-spline: approximates the points
};

/// Continuity at the points where two segments of a curve meet; within a segment everything is continuous.
enum class Continuity : std::uint8_t {
  kNone,          ///< the position jumps
  kPosition,      ///< C0: the velocity jumps
  kVelocity,      ///< C1: the acceleration jumps
  kAcceleration,  ///< C2: the jerk jumps
};

/// Properties of a method.
struct MethodFacts {
  InterpolationMethod method = InterpolationMethod::kHold;
  std::string_view name;  ///< name in line descriptions
  Continuity continuity = Continuity::kNone;
  bool meets_points = true;  ///< false: the curve does not pass through the inner points
};

/// All methods, in the order of InterpolationMethod.
[[nodiscard]] std::span<const MethodFacts> interpolation_methods() noexcept;
/// Finds the method called `name`; valid until the program ends; null if there is none.
[[nodiscard]] const MethodFacts* find_interpolation_method(std::string_view name) noexcept;
/// Properties of `method`. \rtsafe
[[nodiscard]] const MethodFacts& facts_of(InterpolationMethod method) noexcept;

}  // namespace driveline::trajectory
