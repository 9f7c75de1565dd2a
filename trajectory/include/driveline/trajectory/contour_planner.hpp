#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/contour_track.hpp"
#include "driveline/trajectory/path_check.hpp"
#include "driveline/trajectory/path_shaper.hpp"
#include "driveline/trajectory/stepped_limit.hpp"

namespace driveline::trajectory {

/// Plans a path while it is followed: from moves to the speeds at which every axis keeps its limits, far enough ahead
/// that the axes can always come to rest on what is planned. Runs beside the cycle.
class ContourPlanner {
 public:
  /// Plans on `track`, which must outlive it.
  explicit ContourPlanner(ContourTrack& track);

  /// Adds a move. An error leaves everything as it was: what the shaper refuses, and places that the axes must not or
  /// cannot have (PathCheck). To be called when flush() has returned true, or the memory
  /// grows.
  [[nodiscard]] tl::expected<void, PathMoveError> add(const PathMove& move);
  /// The path ends with the last move, at a standstill; more moves may come later.
  void finish();
  /// Hands what has been planned to the cycle, as far as there is room. True: all of it. Otherwise to be called again
  /// when the axes have moved on, some milliseconds later.
  bool flush();

  /// Where the last move ends.
  [[nodiscard]] const GroupVector& target() const noexcept { return shaper_.target(); }
  /// The length of what has been shaped, in m.
  [[nodiscard]] double planned_length() const noexcept { return static_cast<double>(shaped_end_) * kPathTick; }

 private:
  /// A stretch with equal limits, which may still be lowered by what comes.
  struct Stretch {
    PathTicks begin;
    PathTicks end;
    double top;
    double acceleration;
    double feed;
    bool stops;  ///< at its end
    /// Number of the first and the last of the pieces it lies on. The parts of a stretch may name more than theirs.
    std::uint64_t first_piece;
    std::uint64_t last_piece;
    /// So many events are before it, and before its end.
    std::uint64_t first_event;
    std::uint64_t last_event;
    PathTicks spare = 0;  ///< so much at its end could do more
  };
  /// What a stretch asks of an axis, or of the tool: bounds of the derivatives by the length.
  struct Demand {
    double first;
    double second;
    double third;
  };
  /// The same of all axes and the tool, and limits along the path at which every one of them keeps its own.
  struct Bend {
    std::array<Demand, kMaxGroupAxes + 1> demands;
    double top = 0.0;           ///< the highest speed that leaves something for braking
    double acceleration = 0.0;  ///< up to that speed
    bool is_bent = false;
    bool is_coarse = false;  ///< shorter stretches would have better bounds
  };
  /// A stretch whose limits may be exchanged for others: a lower speed, a higher acceleration.
  struct Curved {
    Stretch stretch;
    Bend bend;
    double begin2 = 0.0;  ///< square of the highest speed at its begin
  };

  [[nodiscard]] Bend bend_of(const PathPiece& piece, double begin, double end, double feed) const noexcept;
  [[nodiscard]] double acceleration_at(const Bend& bend, double speed) const noexcept;
  [[nodiscard]] double top_of(const Bend& bend, double share, double top) const noexcept;
  void plan(const ShapedPiece& shaped);
  void plan_stretches(const ShapedPiece& shaped, const Stretch& whole);
  void plan_stretches_of_joints(const ShapedPiece& shaped, const Stretch& stretch, double begin, double end,
                                int halvings);
  [[nodiscard]] double top_for_short_pieces(double length) noexcept;
  void append(const Stretch& stretch, const Bend& bend);
  void append_curved(const Curved& gathered);
  void hand_on_curved(bool all);
  void lower_to_reachable(Curved& curved, double from2) const noexcept;
  void append_shaped(const Stretch& shaped);
  void settle(PathTicks until);
  void settle_beyond_room();
  [[nodiscard]] double top_for_room(const Stretch& stretch) const noexcept;
  [[nodiscard]] bool may_be_one(const Stretch& last, const Stretch& stretch) const noexcept;
  void settle_one(const Stretch& whole);
  bool merge(Stretch& last, const Stretch& stretch) const noexcept;
  bool publish_pieces();
  bool publish_cells();
  bool publish_events(PathTicks until);
  void put_piece(const ContourTrack::Piece& piece);
  void plan_events(const ShapedPiece& shaped, PathTicks begin, PathTicks length);
  void raise_speeds(std::uint64_t first_new, std::uint64_t end);

  ContourTrack& track_;
  const ContourSettings& settings_;
  PathCheck check_;
  PathShaper shaper_;
  double smoothing_s_;
  double reach_s_;          ///< limits hold for so long before and behind their place; speeds change with the cycles
  double top_speed_ = 0.0;  ///< no path is faster
  std::array<ToolLimits, kMaxGroupAxes + 1> limits_{};  ///< of the axes, then of the tool
  std::vector<ShapedPiece> shaped_;
  PathTicks shaped_end_ = 0;
  std::uint64_t planned_pieces_ = 0;
  std::deque<ContourTrack::Piece> pieces_;  ///< to be published, when there is room
  std::deque<ContourTrack::Event> events_;  ///< the same
  std::uint64_t planned_events_ = 0;
  std::optional<Curved> gathered_;      ///< short ones, which may still become one with the next
  std::vector<Curved> curved_;          ///< may still be exchanged
  std::size_t first_curved_ = 0;        ///< those before it are gone
  double curved_brakes2_ = 0.0;         ///< what they can take from the square of a speed, all together
  double reached2_ = 0.0;               ///< square of the highest speed behind them
  std::deque<Stretch> open_;            ///< to be lowered, maybe, with their own limits
  SteppedLimit tops_;                   ///< with their surroundings, from open_ on
  SteppedLimit accelerations_;          ///< the same
  std::deque<Stretch> settled_;         ///< to be published
  std::optional<PathTicks> early_end_;  ///< what ends here could have been lowered, but the room was needed
  std::vector<double> lengths_;         ///< of the last pieces, a ring
  std::size_t next_length_ = 0;
  double sum_of_lengths_ = 0.0;
  double reverse2_ = 0.0;  ///< behind2 of the next cell
  double brakes2_ = 0.0;   ///< the same
  double last_top_ = 0.0;  ///< of the last published cell
};

}  // namespace driveline::trajectory
