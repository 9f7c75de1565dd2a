#pragma once

#include <span>
#include <string>

#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// A SCARA: two horizontal arms and a spindle that rises and rotates. Coordinates x, y, z, c; joints shoulder, elbow,
/// lift, wrist. With all joints at zero the arms are stretched along x. The shoulder angle lies between -pi and pi from
/// x; a path through the half plane behind the shoulder, where that angle would jump, is refused.
class ScaraKinematics final : public Kinematics {
 public:
  /// Dimensions in m.
  struct Shape {
    double upper_arm = 0.0;   ///< length from shoulder to elbow, > 0
    double forearm = 0.0;     ///< length from elbow to spindle, > 0
    bool elbow_left = false;  ///< true: elbow angles are positive; false: negative
  };
  /// Throws std::invalid_argument if a length is invalid.
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
