#include "driveline/trajectory/interpolation_method.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace driveline::trajectory {
namespace {

constexpr std::array<MethodFacts, 8> kMethods{{
    {InterpolationMethod::kHold, "hold", Continuity::kNone, true},
    {InterpolationMethod::kLinear, "linear", Continuity::kPosition, true},
    {InterpolationMethod::kHermite, "hermite", Continuity::kVelocity, true},
    {InterpolationMethod::kNaturalSpline, "natural", Continuity::kAcceleration, true},
    {InterpolationMethod::kClampedSpline, "clamped", Continuity::kAcceleration, true},
    {InterpolationMethod::kQuintic, "quintic", Continuity::kAcceleration, true},
    {InterpolationMethod::kCosine, "cosine", Continuity::kVelocity, true},
    {InterpolationMethod::kBSpline, "bspline", Continuity::kAcceleration, false},
}};

}  // namespace

std::span<const MethodFacts> interpolation_methods() noexcept {
  return kMethods;
}

const MethodFacts* find_interpolation_method(std::string_view name) noexcept {
  const auto found =
      std::find_if(kMethods.begin(), kMethods.end(), [name](const auto& one) { return one.name == name; });
  return found == kMethods.end() ? nullptr : &*found;
}

const MethodFacts& facts_of(InterpolationMethod method) noexcept {
  return kMethods[static_cast<std::size_t>(method)];
}

}  // namespace driveline::trajectory
