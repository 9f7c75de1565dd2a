#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace driveline::trajectory {

/// How the points of a path are joined.
enum class InterpolationMethod : std::uint8_t {
  kHold,           ///< each point is held until the next
  kLinear,         ///< straight lines
  kHermite,        ///< cubics with the velocity given at each point, or estimated
  kNaturalSpline,  ///< cubic spline with free ends
  kClampedSpline,  ///< cubic spline with given velocities at the ends, by default standstill
  kQuintic,        ///< fifth degree, with velocity and acceleration given at each point, or estimated
  kCosine,         ///< half a period of a cosine between two points, standing still at each
  kBSpline,        ///< cubic B-spline: approximates the points
};

/// What is continuous where two segments of a curve meet; everything is within a segment.
enum class Continuity : std::uint8_t {
  kNone,          ///< the position jumps
  kPosition,      ///< C0: the velocity jumps
  kVelocity,      ///< C1: the acceleration jumps
  kAcceleration,  ///< C2: the jerk jumps
};

/// What is known of a method.
struct MethodFacts {
  InterpolationMethod method = InterpolationMethod::kHold;
  std::string_view name;  ///< in line descriptions
  Continuity continuity = Continuity::kNone;
  bool meets_points = true;  ///< false: the curve passes by the inner points
};

/// All methods, in the order of InterpolationMethod.
[[nodiscard]] std::span<const MethodFacts> interpolation_methods() noexcept;
/// The method of this name, valid as long as the program runs; null if there is none.
[[nodiscard]] const MethodFacts* find_interpolation_method(std::string_view name) noexcept;
/// \rtsafe
[[nodiscard]] const MethodFacts& facts_of(InterpolationMethod method) noexcept;

}  // namespace driveline::trajectory
