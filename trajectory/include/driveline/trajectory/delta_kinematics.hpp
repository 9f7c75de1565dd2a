#pragma once

#include <array>
#include <span>
#include <string>

#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// Common part of delta machines: three chains at 0, 120 and 240 degrees around z, each with a pair of rods that holds
/// the platform, which stays level. Coordinates x, y, z, with z upwards from the height of the base.
class DeltaKinematics : public Kinematics {
 public:
  [[nodiscard]] std::span<const KinematicCoordinate> coordinates() const noexcept override;
  [[nodiscard]] std::span<const KinematicCoordinate> joints() const noexcept override;
  [[nodiscard]] bool forward(const GroupVector& joints, GroupVector& tool) const noexcept override;
  [[nodiscard]] PoseFault inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept override;
  [[nodiscard]] std::string explain(const PoseFault& fault) const override;

 protected:
  /// Position in the vertical plane of a chain: outwards from the axis of the machine, and upwards.
  struct Knee {
    double out = 0.0;
    double up = 0.0;
  };

  /// Throws std::invalid_argument unless `rod` is positive and finite.
  DeltaKinematics(double rod, AxisKind joint);

  /// Position of the upper end of the rods, with the platform reduced to a point. \rtsafe
  [[nodiscard]] virtual Knee knee(double joint) const noexcept = 0;
  /// Solves for the joint of a chain, with the platform reduced to a point at these distances: outwards and sideways
  /// from the plane of the chain, and upwards. kUnreachable if there is no solution. \rtsafe
  [[nodiscard]] virtual PoseFault::Kind solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                              PathJet& joint) const noexcept = 0;

  double rod_;  ///< length of the rods, m

 private:
  std::array<KinematicCoordinate, 3> joints_;
};

/// A delta with rotating arms (Clavel's). Its joints are the angles of the upper arms, downwards from the horizontal;
/// the knees point outwards. The platform is below the base.
class RotaryDeltaKinematics final : public DeltaKinematics {
 public:
  /// Dimensions in m.
  struct Shape {
    double base_radius = 0.0;      ///< from the centre to the motor axes, > 0
    double platform_radius = 0.0;  ///< from the centre of the platform to the ends of the rods, > 0
    double upper_arm = 0.0;        ///< length of the upper arms, > 0
    double rod = 0.0;              ///< length of the rods, > 0
  };
  /// Throws std::invalid_argument if a length is invalid.
  explicit RotaryDeltaKinematics(const Shape& shape);

 private:
  [[nodiscard]] Knee knee(double joint) const noexcept override;
  [[nodiscard]] PoseFault::Kind solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                      PathJet& joint) const noexcept override;

  double offset_;  ///< base radius minus platform radius
  double upper_arm_;
};

/// A delta whose chains are carriages on vertical columns. Its joints are their heights; the platform is below them.
class LinearDeltaKinematics final : public DeltaKinematics {
 public:
  /// Dimensions in m.
  struct Shape {
    double column_radius = 0.0;    ///< from the centre to the joints on the carriages, > 0
    double platform_radius = 0.0;  ///< from the centre of the platform to the ends of the rods, > 0
    double rod = 0.0;              ///< length of the rods, > 0
  };
  /// Throws std::invalid_argument if a length is invalid.
  explicit LinearDeltaKinematics(const Shape& shape);

 private:
  [[nodiscard]] Knee knee(double joint) const noexcept override;
  [[nodiscard]] PoseFault::Kind solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                      PathJet& joint) const noexcept override;

  double offset_;  ///< column radius minus platform radius
};

}  // namespace driveline::trajectory
