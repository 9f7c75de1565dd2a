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
  std::uint32_t output = 0;  ///< number of the output, assigned by the user
  double value = 0.0;        ///< new value
};

/// An output that is changed by a move.
struct MoveOutput {
  PathOutput change;  ///< the change
  /// Position of the change along the move, before its corners are rounded, in m or rad; negative: distance before its
  /// end; infinite: at its end.
  double at = std::numeric_limits<double>::infinity();
};

/// One move of a group along its path, starting at the end of the previous move.
struct PathMove {
  /// Shape of the move.
  enum class Kind : std::uint8_t {
    kLine,    ///< straight line to `target`
    kArc,     ///< circular arc around `center`, in the plane of two axes, to `target`
    kArcVia,  ///< circular arc through `via` to `target`, in the space of all axes
    kSpline,  ///< natural cubic spline through `points`, ending at the last one
  };

  Kind kind = Kind::kLine;            ///< shape of the move
  GroupVector target{};               ///< end position, rad or m; not for kSpline
  GroupVector center{};               ///< kArc: the centre, in the two axes of the plane
  GroupVector via{};                  ///< kArcVia: a point on the arc
  std::vector<GroupVector> points{};  ///< kSpline: at least one point
  std::size_t first_axis = 0;         ///< kArc: the axis that turns towards `second_axis`
  std::size_t second_axis = 1;        ///< kArc: the other axis of the plane
  bool clockwise = false;             ///< kArc: turn from `second_axis` towards `first_axis` instead
  double feed = 0.0;                  ///< feed along the path, m/s or rad/s, > 0; infinite: as fast as the axes allow
  /// Largest deviation of the path from the corner between this move and the next one, m or rad. 0: the axes stop there
  /// unless the path continues without a change of direction and curvature.
  double tolerance = 0.0;
  double dwell_s = 0.0;  ///< standstill at the end of the move, regardless of `tolerance`, 0 to kLongestDwell
  /// Outputs changed while the axes pass. In a rounded corner their positions scale with the length of the blend, whose
  /// middle is the end of the move. A move of zero length changes them at the present position.
  std::vector<MoveOutput> outputs{};
};

/// Longest dwell in s.
inline constexpr double kLongestDwell = 3600.0;
/// Maximum number of outputs and dwells between two moves of non-zero length.
inline constexpr std::size_t kMaxOutputsOfMove = 64;

/// Reason why a move was refused.
struct PathMoveError {
  std::string reason;  ///< one sentence without a full stop, without file and line
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const PathMoveError& error) {
  return error.reason;
}

/// Largest difference between the distances of both ends of an arc from its centre, as a fraction of the radius.
inline constexpr double kArcClosure = 1e-4;

}  // namespace driveline::trajectory
