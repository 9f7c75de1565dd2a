#pragma once

#include <span>
#include <string>

#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// A SCARA: two horizontal arms, a spindle that rises and turns. Coordinates x, y, z, c; joints shoulder, elbow, lift,
/// wrist. With all joints at zero the arms are stretched along x. The shoulder is within half a turn to both sides of
/// x: a path through the half plane behind it, where it would leap, is refused.
class ScaraKinematics final : public Kinematics {
 public:
  /// Lengths in m.
  struct Shape {
    double upper_arm = 0.0;   ///< from shoulder to elbow, > 0
    double forearm = 0.0;     ///< from elbow to spindle, > 0
    bool elbow_left = false;  ///< angles of the elbow are above zero; otherwise below
  };
  /// Throws std::invalid_argument.
  explicit ScaraKinematics(const Shape& shape);

  [[nodiscard]] std::span<const KinematicCoordinate> coordinates() const noexcept override;
  [[nodiscard]] std::span<const KinematicCoordinate> joints() const noexcept override;
  [[nodiscard]] bool forward(const GroupVector& joints, GroupVector& tool) const noexcept override;
  [[nodiscard]] PoseFault inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept override;
  [[nodiscard]] std::string explain(const PoseFault& fault) const override;

 private:
  Shape shape_;
};

}  // namespace driveline::trajectory
