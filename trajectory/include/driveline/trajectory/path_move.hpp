#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "driveline/trajectory/group_vector.hpp"

namespace driveline::trajectory {

/// A change of an output of the machine at a point of the path: a valve, a laser, a gripper.
struct PathOutput {
  std::uint32_t output = 0;  ///< which one, as the user counts them
  double value = 0.0;        ///< what it becomes
};

/// An output that a move changes.
struct MoveOutput {
  PathOutput change;  ///< what
  /// How far along the move, before its corners are rounded, in m or rad; below zero: so far before its end; infinite:
  /// at its end.
  double at = std::numeric_limits<double>::infinity();
};

/// One move of a group along its path, from where the move before it ends.
struct PathMove {
  /// The shape of the way.
  enum class Kind : std::uint8_t {
    kLine,    ///< straight to `target`
    kArc,     ///< on a circle around `center`, in the plane of two axes, to `target`
    kArcVia,  ///< on the circle through `via` to `target`, in the space of all axes
    kSpline,  ///< on a natural cubic spline through `points`, the last of which is the target
  };

  Kind kind = Kind::kLine;            ///< the shape
  GroupVector target{};               ///< where it ends, rad or m; not for kSpline
  GroupVector center{};               ///< kArc: the centre, in the two axes of the plane
  GroupVector via{};                  ///< kArcVia: a point on the way
  std::vector<GroupVector> points{};  ///< kSpline: at least one
  std::size_t first_axis = 0;         ///< kArc: the axis that turns towards `second_axis`
  std::size_t second_axis = 1;        ///< kArc: the other axis of the plane
  bool clockwise = false;             ///< kArc: from `second_axis` towards `first_axis`
  double feed = 0.0;                  ///< along the path, m/s or rad/s, > 0; infinite: as fast as the axes can
  /// How far the path may leave the corner between this move and the one behind it, m or rad. 0: the axes stop there
  /// unless the path goes on without a change of direction and curvature.
  double tolerance = 0.0;
  double dwell_s = 0.0;  ///< the axes stand at its end for so long, whatever the tolerance, 0 to kLongestDwell
  /// Changed while the axes pass. In a rounded corner they are as far along the blend, in proportion; the end of the
  /// move is its middle. A move without way changes them where the axes are.
  std::vector<MoveOutput> outputs{};
};

/// s
inline constexpr double kLongestDwell = 3600.0;
/// Outputs and dwells between two moves with a way are no more.
inline constexpr std::size_t kMostOutputsOfMove = 64;

/// Why a move was refused.
struct PathMoveError {
  std::string reason;  ///< one sentence without a full stop, and without file and line
};

/// Arcs around a centre end at another distance from it than they begin with by up to this share of the radius.
inline constexpr double kArcClosure = 1e-4;

}  // namespace driveline::trajectory
