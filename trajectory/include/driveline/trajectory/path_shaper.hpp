#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/path_check.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// What happens at a point of a piece: an output changes, or the axes stand for some time.
struct PathEvent {
  double at = 0.0;       ///< along the piece, m or rad
  PathOutput change{};   ///< where they do not stand
  double dwell_s = 0.0;  ///< above zero: the axes stand, here only, where the path stops
};

/// A piece of the path, ready to be planned.
struct ShapedPiece {
  PathPiece piece;                  ///< its geometry
  double feed = 0.0;                ///< m/s or rad/s
  std::uint64_t move = 0;           ///< number of its move, 0 is the first; a blend belongs to the move behind it
  bool stops = false;               ///< the axes stand still at its end
  std::vector<PathEvent> events{};  ///< on the way, in their order
};

/// Makes a path of moves: joins them, rounds their corners within the tolerance, and hands over pieces that go on in
/// place, direction and curvature, or stop. It keeps the last move back, since its end depends on the next one, and
/// needs no memory for what it has handed over. For the planning side; not for the cycle.
class PathShaper {
 public:
  /// `axes`: from 1 to kMaxGroupAxes; `start`: where the path begins; `check`, which must outlive it, judges each move,
  /// as it is asked for and with its corner rounded, before it is taken. Throws std::invalid_argument otherwise.
  PathShaper(std::size_t axes, const GroupVector& start, const PathCheck* check = nullptr);

  /// Appends what a move makes final to `out`. A move that ends where it begins has no pieces, unless it is an arc
  /// around a centre, which is a whole circle; its outputs and its dwell are those of the end of the move before it, or
  /// of the begin of the next one if the path begins here. An error leaves everything as it was.
  [[nodiscard]] tl::expected<void, PathMoveError> add(const PathMove& move, std::vector<ShapedPiece>& out);
  /// The path ends here, for now: appends the rest, which ends at a standstill.
  void finish(std::vector<ShapedPiece>& out);

  /// Where the last move ends.
  [[nodiscard]] const GroupVector& target() const noexcept { return target_; }

 private:
  [[nodiscard]] tl::expected<std::vector<PathPiece>, PathMoveError> shaped(const PathMove& move) const;
  void hand_over(std::vector<ShapedPiece>& out, bool stops);
  void add_without_way(const PathMove& move);
  [[nodiscard]] std::vector<PathEvent> take_events_of_corner(double cut, double corner, std::vector<PathEvent>& behind);

  [[nodiscard]] tl::expected<void, PathMoveError> checked(const std::vector<PathPiece>& pieces) const;

  std::size_t axes_;
  const PathCheck* check_;
  GroupVector target_;
  std::vector<PathPiece> last_;    ///< the move that is kept back; empty: none
  double last_half_ = 0.0;         ///< half of its last piece, as it was before a corner took from it
  double feed_ = 0.0;              ///< of it
  double tolerance_ = 0.0;         ///< at its end
  std::vector<PathEvent> events_;  ///< of it, by the length of what is kept; without a move those of the next one
  bool dwells_ = false;            ///< the axes stand at its end for some time
  std::uint64_t moves_ = 0;        ///< so many have been added
  std::uint64_t last_move_ = 0;    ///< number of the one that is kept back
};

}  // namespace driveline::trajectory
