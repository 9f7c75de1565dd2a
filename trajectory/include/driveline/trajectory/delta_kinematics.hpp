#pragma once

#include <array>
#include <span>
#include <string>

#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// What deltas have in common: three chains at 0, 120 and 240 degrees around z, each with a pair of rods that holds a
/// platform, which stays level. Coordinates x, y, z, with z upwards from the height of the base.
class DeltaKinematics : public Kinematics {
 public:
  [[nodiscard]] std::span<const KinematicCoordinate> coordinates() const noexcept override;
  [[nodiscard]] std::span<const KinematicCoordinate> joints() const noexcept override;
  [[nodiscard]] bool forward(const GroupVector& joints, GroupVector& tool) const noexcept override;
  [[nodiscard]] PoseFault inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept override;
  [[nodiscard]] std::string explain(const PoseFault& fault) const override;

 protected:
  /// In the vertical plane of a chain: from its axis outwards, and upwards.
  struct Knee {
    double out = 0.0;
    double up = 0.0;
  };

  /// Throws std::invalid_argument unless it is positive and finite.
  DeltaKinematics(double rod, AxisKind joint);

  /// Where the upper end of the rods would be for a platform that is a point. \rtsafe
  [[nodiscard]] virtual Knee knee(double joint) const noexcept = 0;
  /// The joint of a chain for a platform that is a point at these distances: outwards and sideways of the plane of the
  /// chain, and upwards. Not reachable: kind kUnreachable. \rtsafe
  [[nodiscard]] virtual PoseFault::Kind solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                              PathJet& joint) const noexcept = 0;

  double rod_;  ///< length of the rods, m

 private:
  std::array<KinematicCoordinate, 3> joints_;
};

/// A delta with turning arms (Clavel's). Its joints are the angles of the upper arms from the horizontal downwards; the
/// knees are outside. The platform is below the base.
class RotaryDeltaKinematics final : public DeltaKinematics {
 public:
  /// Lengths in m.
  struct Shape {
    double base_radius = 0.0;      ///< from the middle to the axes of the motors, > 0
    double platform_radius = 0.0;  ///< from the middle of the platform to the ends of the rods, > 0
    double upper_arm = 0.0;        ///< > 0
    double rod = 0.0;              ///< > 0
  };
  /// Throws std::invalid_argument.
  explicit RotaryDeltaKinematics(const Shape& shape);

 private:
  [[nodiscard]] Knee knee(double joint) const noexcept override;
  [[nodiscard]] PoseFault::Kind solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                      PathJet& joint) const noexcept override;

  double offset_;  ///< base radius without that of the platform
  double upper_arm_;
};

/// A delta whose chains are carriages on vertical columns. Its joints are their heights; the platform is below them.
class LinearDeltaKinematics final : public DeltaKinematics {
 public:
  /// Lengths in m.
  struct Shape {
    double column_radius = 0.0;    ///< from the middle to the joints on the carriages, > 0
    double platform_radius = 0.0;  ///< from the middle of the platform to the ends of the rods, > 0
    double rod = 0.0;              ///< > 0
  };
  /// Throws std::invalid_argument.
  explicit LinearDeltaKinematics(const Shape& shape);

 private:
  [[nodiscard]] Knee knee(double joint) const noexcept override;
  [[nodiscard]] PoseFault::Kind solve(const PathJet& out, const PathJet& side, const PathJet& up,
                                      PathJet& joint) const noexcept override;

  double offset_;  ///< column radius without that of the platform
};

}  // namespace driveline::trajectory
