#pragma once

#include <span>
#include <string>

#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// A machine whose joints are the coordinates x, y, z of the tool.
class CartesianKinematics final : public Kinematics {
 public:
  [[nodiscard]] std::span<const KinematicCoordinate> coordinates() const noexcept override;
  [[nodiscard]] std::span<const KinematicCoordinate> joints() const noexcept override;
  [[nodiscard]] bool forward(const GroupVector& joints, GroupVector& tool) const noexcept override;
  [[nodiscard]] PoseFault inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept override;
  [[nodiscard]] std::string explain(const PoseFault& fault) const override;
};

}  // namespace driveline::trajectory
