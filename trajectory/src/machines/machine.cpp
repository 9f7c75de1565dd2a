#include "driveline/trajectory/machine.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "text.hpp"

namespace driveline::trajectory {
namespace {

/// Difference in m up to which two lengths are equal.
constexpr double kSameLength = 1e-9;

const KinematicKind* find_kind(std::string_view name) {
  const auto kinds = kinematic_kinds();
  const auto found = std::find_if(kinds.begin(), kinds.end(), [&](const auto& kind) { return kind.name == name; });
  return found == kinds.end() ? nullptr : &*found;
}

bool has(std::span<const std::string_view> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

Machine::Machine(std::string_view kind, const PositionUnit& unit, std::vector<MachineValue> values,
                 std::shared_ptr<const Kinematics> kinematics)
    : kind_(kind), unit_(&unit), values_(std::move(values)), kinematics_(std::move(kinematics)) {}

tl::expected<Machine, KinematicError> Machine::make(std::string_view kind, std::string_view unit,
                                                    std::vector<MachineValue> values) {
  const auto* const length = find_position_unit(unit);
  if (length == nullptr || length->kind != AxisKind::kLinear)
    return tl::unexpected(KinematicError{"the unit of kinematics must be \"m\", \"mm\" or \"um\"", "unit"});
  std::vector<KinematicParameter> parameters;
  parameters.reserve(values.size());
  const auto* const known = find_kind(kind);
  for (const auto& value : values) {
    parameters.push_back({value.name, value.is_choice ? value.value : length->to_si(value.value)});
    if (known == nullptr) continue;
    if (!value.is_choice && has(known->choices, value.name))
      return tl::unexpected(KinematicError{value.name + " must be true or false", value.name});
    if (value.is_choice && has(known->lengths, value.name))
      return tl::unexpected(KinematicError{value.name + " must be a number", value.name});
  }
  auto made = make_kinematics(kind, parameters);
  if (!made) return tl::unexpected(std::move(made.error()));
  return Machine(kind, *length, std::move(values), std::move(*made));
}

std::vector<NamedAxis> Machine::coordinates(std::span<const NamedAxis> axes) const {
  std::vector<NamedAxis> made(axes.begin(), axes.end());
  const auto tool = kinematics_->coordinates();
  for (std::size_t i = 0; i < tool.size() && i < made.size(); ++i)
    made[i] = {std::string(tool[i].name), &unit_of(tool[i])};
  return made;
}

const PositionUnit& Machine::unit_of(const KinematicCoordinate& coordinate) const {
  return coordinate.kind == AxisKind::kRotary ? *find_position_unit("deg") : *unit_;
}

std::string Machine::fault_of(std::span<const NamedAxis> axes) const {
  const auto joints = kinematics_->joints();
  if (axes.size() < joints.size()) {
    return "the machine has " + std::to_string(joints.size()) + " joints, the group " + std::to_string(axes.size()) +
           " axes";
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (axes[i].unit->kind == joints[i].kind) continue;
    const bool turns = joints[i].kind == AxisKind::kRotary;
    return "axis " + axes[i].name + " is " + (turns ? "a turning joint" : "a sliding joint") +
           " of the machine; its unit must be one of " + (turns ? "angles" : "lengths");
  }
  return "";
}

double Machine::value_of(std::string_view name) const {
  const auto found =
      std::find_if(values_.begin(), values_.end(), [&](const MachineValue& value) { return value.name == name; });
  if (found == values_.end()) return 0.0;
  return found->is_choice ? found->value : unit_->to_si(found->value);
}

std::string Machine::difference_to(const Machine& other) const {
  if (kind_ != other.kind_) return "its kind is " + other.kind_ + ", not " + kind_;
  const auto* const kind = find_kind(kind_);
  for (const auto name : kind->lengths) {
    const double own = value_of(name);
    const double others = other.value_of(name);
    if (std::abs(own - others) <= kSameLength) continue;
    return std::string(name) + " is " + to_short_text(unit_->from_si(others)) + " " + std::string(unit_->name) +
           ", not " + to_short_text(unit_->from_si(own)) + " " + std::string(unit_->name);
  }
  for (const auto name : kind->choices) {
    if (value_of(name) != other.value_of(name))
      return std::string(name) + " is " + (other.value_of(name) != 0.0 ? "true" : "false") + ", not " +
             (value_of(name) != 0.0 ? "true" : "false");
  }
  return "";
}

}  // namespace driveline::trajectory
