#include "driveline/trajectory/cartesian_kinematics.hpp"

#include <array>

namespace driveline::trajectory {
namespace {

constexpr std::array<KinematicCoordinate, 3> kTranslations{
    {{"x", AxisKind::kLinear}, {"y", AxisKind::kLinear}, {"z", AxisKind::kLinear}}};

}  // namespace

std::span<const KinematicCoordinate> CartesianKinematics::coordinates() const noexcept {
  return kTranslations;
}

std::span<const KinematicCoordinate> CartesianKinematics::joints() const noexcept {
  return kTranslations;
}

bool CartesianKinematics::forward(const GroupVector& joints, GroupVector& tool) const noexcept {
  for (std::size_t i = 0; i < kTranslations.size(); ++i) tool[i] = joints[i];
  return true;
}

PoseFault CartesianKinematics::inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept {
  for (std::size_t i = 0; i < kTranslations.size(); ++i) put(joints, i, jet(tool, i));
  return {};
}

std::string CartesianKinematics::explain(const PoseFault& /*fault*/) const {
  return "the machine can be anywhere";
}

}  // namespace driveline::trajectory
