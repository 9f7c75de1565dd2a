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

/// An event at a point of a piece: an output changes, or the axes dwell.
struct PathEvent {
  double at = 0.0;       ///< position along the piece, m or rad
  PathOutput change{};   ///< the output change, unless it is a dwell
  double dwell_s = 0.0;  ///< above zero: the axes dwell; only at a stop of the path
};

/// A piece of the path, ready for planning.
struct ShapedPiece {
  PathPiece piece;                  ///< its geometry
  double feed = 0.0;                ///< m/s or rad/s
  std::uint64_t move = 0;           ///< number of its move, from 0; a blend belongs to the move after it
  bool stops = false;               ///< the axes stop at its end
  std::vector<PathEvent> events{};  ///< events on the piece, in order
};

/// Turns moves into a path: joins them, rounds their corners within the tolerance, and returns pieces that continue in
/// position, direction and curvature, or stop. It holds back the last move, because the end of that move depends on the
/// next one, and stores nothing of the pieces it has returned. For the planning side; not for the cycle.
class PathShaper {
 public:
  /// `axes`: 1 to kMaxGroupAxes; `start`: start of the path; `check`, which must outlive it, checks each move, as
  /// requested and with its corner rounded, before it is accepted. Throws std::invalid_argument if an argument is
  /// invalid.
  PathShaper(std::size_t axes, const GroupVector& start, const PathCheck* check = nullptr);

  /// Appends to `out` the pieces that a move makes final. A move that ends where it starts has no pieces, unless it is
  /// an arc around a centre, which is then a full circle; its outputs and its dwell are added to the end of the
  /// previous move, or to the start of the next one if the path starts here. An error changes nothing.
  [[nodiscard]] tl::expected<void, PathMoveError> add(const PathMove& move, std::vector<ShapedPiece>& out);
  /// Ends the path for now: appends the remaining pieces, which end at standstill.
  void finish(std::vector<ShapedPiece>& out);

  /// End position of the last move.
  [[nodiscard]] const GroupVector& target() const noexcept { return target_; }

 private:
  /// Between the move held back and the next one.
  struct Corner {
    double cut = 0.0;               ///< length cut from both moves
    std::vector<PathPiece> pieces;  ///< in place of what was cut
    bool stops = false;             ///< the axes stop there
  };

  [[nodiscard]] tl::expected<std::vector<PathPiece>, PathMoveError> shaped(const PathMove& move) const;
  [[nodiscard]] tl::expected<Corner, PathMoveError> join(std::vector<PathPiece>& pieces);
  void hand_over(std::vector<ShapedPiece>& out, bool stops);
  void add_without_way(const PathMove& move);
  [[nodiscard]] std::vector<PathEvent> take_events_of_corner(double cut, double corner, std::vector<PathEvent>& behind);

  [[nodiscard]] tl::expected<void, PathMoveError> checked(const std::vector<PathPiece>& pieces) const;

  std::size_t axes_;
  const PathCheck* check_;
  GroupVector target_;
  std::vector<PathPiece> last_;    ///< the move held back; empty: none
  double last_half_ = 0.0;         ///< half of the length of its last piece, before a corner was cut off
  double feed_ = 0.0;              ///< feed of that move
  double tolerance_ = 0.0;         ///< tolerance at its end
  std::vector<PathEvent> events_;  ///< its events by remaining length; without a move: events of the next one
  bool dwells_ = false;            ///< the axes dwell at its end
  std::uint64_t moves_ = 0;        ///< number of moves added
  std::uint64_t last_move_ = 0;    ///< number of the move held back
};

}  // namespace driveline::trajectory
