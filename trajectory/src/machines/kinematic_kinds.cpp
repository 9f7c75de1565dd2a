#include "driveline/trajectory/kinematic_kinds.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "driveline/trajectory/cartesian_kinematics.hpp"
#include "driveline/trajectory/delta_kinematics.hpp"
#include "driveline/trajectory/scara_kinematics.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::array<std::string_view, 2> kScaraLengths{"upper_arm", "forearm"};
constexpr std::array<std::string_view, 1> kScaraChoices{"elbow_left"};
constexpr std::array<std::string_view, 4> kDeltaLengths{"base_radius", "platform_radius", "upper_arm", "rod"};
constexpr std::array<std::string_view, 3> kLinearDeltaLengths{"column_radius", "platform_radius", "rod"};

constexpr std::array<KinematicKind, 4> kKinds{{{"cartesian", {}, {}},
                                               {"scara", kScaraLengths, kScaraChoices},
                                               {"delta", kDeltaLengths, {}},
                                               {"linear_delta", kLinearDeltaLengths, {}}}};

bool is_one_of(std::string_view name, std::span<const std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

using Parameters = std::span<const KinematicParameter>;

KinematicError fault_of(const KinematicKind& kind, Parameters parameters) {
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto name = parameters[k].name;
    const double value = parameters[k].value;
    const auto before = parameters.first(k);
    if (std::any_of(before.begin(), before.end(), [&](const auto& other) { return other.name == name; })) {
      return {"there are two values of " + std::string(name), std::string(name)};
    }
    if (is_one_of(name, kind.lengths)) {
      if (!(value > 0.0 && std::isfinite(value))) {
        return {std::string(name) + " is " + to_short_text(value) + " m; it must be above 0", std::string(name)};
      }
    } else if (!is_one_of(name, kind.choices)) {
      return {"a machine of kind " + std::string(kind.name) + " has no " + in_quotes(name), std::string(name)};
    }
  }
  for (const auto& name : kind.lengths) {
    if (std::none_of(parameters.begin(), parameters.end(), [&](const auto& each) { return each.name == name; })) {
      return {"a machine of kind " + std::string(kind.name) + " needs " + std::string(name)};
    }
  }
  return {};
}

}  // namespace

std::span<const KinematicKind> kinematic_kinds() noexcept {
  return kKinds;
}

tl::expected<std::unique_ptr<Kinematics>, KinematicError> make_kinematics(std::string_view kind,
                                                                          Parameters parameters) {
  const auto* const known =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const KinematicKind& each) { return each.name == kind; });
  if (known == kKinds.end()) {
    return tl::unexpected(KinematicError{
        "there is no machine of kind " + in_quotes(kind) + "; there are cartesian, scara, delta and linear_delta",
        "type"});
  }
  if (auto fault = fault_of(*known, parameters); !fault.reason.empty()) return tl::unexpected(std::move(fault));
  const auto value = [&](std::string_view name) {
    for (const auto& each : parameters) {
      if (each.name == name) return each.value;
    }
    return 0.0;
  };
  if (kind == "scara") {
    return std::make_unique<ScaraKinematics>(
        ScaraKinematics::Shape{value("upper_arm"), value("forearm"), value("elbow_left") != 0.0});
  }
  if (kind == "delta") {
    return std::make_unique<RotaryDeltaKinematics>(
        RotaryDeltaKinematics::Shape{value("base_radius"), value("platform_radius"), value("upper_arm"), value("rod")});
  }
  if (kind == "linear_delta") {
    return std::make_unique<LinearDeltaKinematics>(
        LinearDeltaKinematics::Shape{value("column_radius"), value("platform_radius"), value("rod")});
  }
  return std::make_unique<CartesianKinematics>();
}

}  // namespace driveline::trajectory
