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

/// Reason why a machine cannot reach a position, or must not pass through it.
struct PoseFault {
  /// Kind of the fault.
  enum class Kind : std::uint8_t {
    kNone,         ///< no fault
    kUnreachable,  ///< no joint positions give this tool position
    kSingular,     ///< reachable, but nearby a small step of the tool is a large step of a joint, or none at all
  };
  Kind kind = Kind::kNone;
  /// The affected joint; kAllJoints: all together.
  std::size_t joint = kAllJoints;

  /// Value of `joint` if no single joint is affected.
  static constexpr std::size_t kAllJoints = kMaxGroupAxes;
};

/// A coordinate of the tool, or a joint of the machine.
struct KinematicCoordinate {
  std::string_view name;              ///< e.g. "x"
  AxisKind kind = AxisKind::kLinear;  ///< length or angle
};

/// Mapping between the joints of a machine and the coordinates of its tool, which are equal in number. Paths are given
/// in tool coordinates; drives receive joint positions. Created at start-up and not changed afterwards, so that cycle
/// and planner may share it.
class Kinematics {
 public:
  Kinematics() = default;
  virtual ~Kinematics() = default;
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  /// Coordinates of the tool: the first axes of the group's moves. Further axes of a group are joints and coordinates
  /// at the same time.
  [[nodiscard]] virtual std::span<const KinematicCoordinate> coordinates() const noexcept = 0;
  /// Joints of the machine, as many as coordinates().
  [[nodiscard]] virtual std::span<const KinematicCoordinate> joints() const noexcept = 0;

  /// Computes the tool position. Returns false if the machine cannot be assembled with these joint positions. Does not
  /// change the values of other axes. \rtsafe
  [[nodiscard]] virtual bool forward(const GroupVector& joints, GroupVector& tool) const noexcept = 0;
  /// Computes the joint positions and their derivatives with respect to the length of the tool path from those of the
  /// tool (by PathJet). Writes nothing if the position is unreachable; near a singular position the values are correct
  /// as far as they are finite. Does not change the values of other axes. \rtsafe
  [[nodiscard]] virtual PoseFault inverse(const PathGeometry& tool, PathGeometry& joints) const noexcept = 0;
  /// Describes the fault as the end of a sentence, e.g. "arm 2 is too short for it".
  [[nodiscard]] virtual std::string explain(const PoseFault& fault) const = 0;

 protected:
  /// Extracts a coordinate with its derivatives. \rtsafe
  [[nodiscard]] static PathJet jet(const PathGeometry& from, std::size_t axis) noexcept {
    return {from.position[axis], from.first[axis], from.second[axis], from.third[axis]};
  }
  /// Stores a coordinate with its derivatives. \rtsafe
  static void put(PathGeometry& to, std::size_t axis, const PathJet& jet) noexcept {
    to.position[axis] = jet.value;
    to.first[axis] = jet.first;
    to.second[axis] = jet.second;
    to.third[axis] = jet.third;
  }
};

/// Sine of the angle between two arms, or its equivalent, below which a position counts as singular.
inline constexpr double kSingularSine = 0.02;

}  // namespace driveline::trajectory
