#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// A piece of the path, ready to be planned.
struct ShapedPiece {
  PathPiece piece;         ///< its geometry
  double feed = 0.0;       ///< m/s or rad/s
  std::uint64_t move = 0;  ///< number of its move, 0 is the first; a blend belongs to the move behind it
  bool stops = false;      ///< the axes stand still at its end
};

/// Makes a path of moves: joins them, rounds their corners within the tolerance, and hands over pieces that go on in
/// place, direction and curvature, or stop. It keeps the last move back, since its end depends on the next one, and
/// needs no memory for what it has handed over. For the planning side; not for the cycle.
class PathShaper {
 public:
  /// `axes`: from 1 to kMaxGroupAxes; `start`: where the path begins. Throws std::invalid_argument otherwise.
  PathShaper(std::size_t axes, const GroupVector& start);

  /// Appends what a move makes final to `out`. A move that ends where it begins is left out, unless it is an arc around
  /// a centre, which is a whole circle. An error leaves everything as it was.
  [[nodiscard]] tl::expected<void, PathMoveError> add(const PathMove& move, std::vector<ShapedPiece>& out);
  /// The path ends here, for now: appends the rest, which ends at a standstill.
  void finish(std::vector<ShapedPiece>& out);

  /// Where the last move ends.
  [[nodiscard]] const GroupVector& target() const noexcept { return target_; }

 private:
  [[nodiscard]] tl::expected<std::vector<PathPiece>, PathMoveError> shaped(const PathMove& move) const;
  void hand_over(std::vector<ShapedPiece>& out, bool stops);

  std::size_t axes_;
  GroupVector target_;
  std::vector<PathPiece> last_;  ///< the move that is kept back; empty: none
  double last_half_ = 0.0;       ///< half of its last piece, as it was before a corner took from it
  double feed_ = 0.0;            ///< of it
  double tolerance_ = 0.0;       ///< at its end
  std::uint64_t moves_ = 0;      ///< so many have been added
  std::uint64_t last_move_ = 0;  ///< number of the one that is kept back
};

}  // namespace driveline::trajectory
