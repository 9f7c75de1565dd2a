#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "driveline/trajectory/group_vector.hpp"
#include "driveline/trajectory/path_jet.hpp"
#include "driveline/trajectory/path_piece.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::trajectory {

/// Why a machine cannot be at a place, or must not pass it.
struct PoseFault {
  /// What kind.
  enum class Kind : std::uint8_t {
    kNone,         ///< it can
    kUnreachable,  ///< there is no position of the joints for it
    kSingular,     ///< there is one, but near it a small step of the tool is a large one of a joint, or none at all
  };
  Kind kind = Kind::kNone;
  /// The joint it is about; kAllJoints: all together.
  std::size_t joint = kAllJoints;

  /// No joint in particular.
  static constexpr std::size_t kAllJoints = kMaxGroupAxes;
};

/// A coordinate of the tool, or a joint of the machine.
struct KinematicCoordinate {
  std::string_view name;              ///< "x"
  AxisKind kind = AxisKind::kLinear;  ///< a length or an angle
};

/// How the joints of a machine and the coordinates of its tool belong together; there are as many of the one as of the
/// other. Paths are given in the coordinates of the tool, drives are told positions of joints. Made at start-up, and
/// not changed afterwards, so that cycle and planner may use the same one.
class Kinematics {
 public:
  Kinematics() = default;
  virtual ~Kinematics() = default;
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  /// Of the tool: the first axes of the group's moves. The axes of a group behind them are joints and coordinates at
  /// once.
  [[nodiscard]] virtual std::span<const KinematicCoordinate> coordinates() const noexcept = 0;
  /// Of the machine, as many.
  [[nodiscard]] virtual std::span<const KinematicCoordinate> joints() const noexcept = 0;

  /// Where the tool is. False: with such joints the machine cannot be put together. Values of other axes are left
  /// alone. \rtsafe
  [[nodiscard]] virtual bool forward(const GroupVector& joints, GroupVector& tool) const noexcept = 0;
  /// Where the joints are, and their derivatives by the length of the path of the tool, from those of the tool (PathJet
  /// does it). Nothing is written when the place is unreachable; near a singular one the values are right, as far as
  /// they are finite. Values of other axes are left alone. \rtsafe
  [[nodiscard]] virtual PoseFault inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept = 0;
  /// The fault as the end of a sentence: "arm 2 is too short for it".
  [[nodiscard]] virtual std::string explain(const PoseFault& fault) const = 0;

 protected:
  /// A coordinate with its derivatives. \rtsafe
  [[nodiscard]] static PathJet jet(const PathGeometry& from, std::size_t axis) noexcept {
    return {from.position[axis], from.first[axis], from.second[axis], from.third[axis]};
  }
  /// The other way. \rtsafe
  static void put(PathGeometry& to, std::size_t axis, const PathJet& jet) noexcept {
    to.position[axis] = jet.value;
    to.first[axis] = jet.first;
    to.second[axis] = jet.second;
    to.third[axis] = jet.third;
  }
};

/// Sine of the angle between two arms, or what corresponds to it, below which a place counts as singular.
inline constexpr double kSingularSine = 0.02;

}  // namespace driveline::trajectory
