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

/// Plans a path while it is followed: turns moves into speeds at which every axis keeps its limits, far enough ahead
/// that the axes can always come to rest on the planned part. Runs outside the cycle.
class ContourPlanner {
 public:
  /// Plans on `track`, which must outlive it.
  explicit ContourPlanner(ContourTrack& track);

  /// Adds a move. Errors: the shaper refuses the move, or the path leads to positions that the axes must not or cannot
  /// reach (PathCheck). An error changes nothing. Call it only after flush() has returned true; otherwise the memory
  /// grows.
  [[nodiscard]] tl::expected<void, PathMoveError> add(const PathMove& move);
  /// Ends the path with the last move, at standstill; more moves may follow later.
  void finish();
  /// Passes the planned part to the cycle, as far as there is room. Returns true if all of it was passed; otherwise
  /// call it again some milliseconds later, when the axes have moved on.
  bool flush();

  /// End position of the last move.
  [[nodiscard]] const GroupVector& target() const noexcept { return shaper_.target(); }
  /// Length of the shaped path in m.
  [[nodiscard]] double planned_length() const noexcept { return static_cast<double>(shaped_end_) * kPathTick; }

 private:
  /// A part of the path with equal limits, which following stretches may still lower.
  struct Stretch {
    PathTicks begin;
    PathTicks end;
    double top;
    double acceleration;
    double feed;
    bool stops;  ///< the axes stop at its end
    /// First and last piece that the stretch lies on. For parts of a stretch the range may be larger than necessary.
    std::uint64_t first_piece;
    std::uint64_t last_piece;
    /// Number of events before its start, and before its end.
    std::uint64_t first_event;
    std::uint64_t last_event;
    PathTicks spare = 0;  ///< length at its end whose own limits are higher
  };
  /// Demand of a stretch on an axis, or on the tool: bounds of the derivatives with respect to the length.
  struct Demand {
    double first;
    double second;
    double third;
  };
  /// Demands on all axes and the tool, and limits along the path at which each of them keeps its own limits.
  struct Bend {
    std::array<Demand, kMaxGroupAxes + 1> demands;
    double top = 0.0;           ///< highest speed that leaves a reserve for braking
    double acceleration = 0.0;  ///< highest acceleration at speeds up to `top`
    bool is_bent = false;
    bool is_coarse = false;  ///< shorter stretches would have tighter bounds
  };
  /// A stretch whose limits may still change to a lower speed with a higher acceleration.
  struct Curved {
    Stretch stretch;
    Bend bend;
    double begin2 = 0.0;  ///< square of the highest speed at its start
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
  double reach_s_;  ///< time around a position during which its limits hold, because of averaging and discrete cycles
  double top_speed_ = 0.0;                              ///< highest speed of any path
  std::array<ToolLimits, kMaxGroupAxes + 1> limits_{};  ///< limits of the axes, then of the tool
  std::vector<ShapedPiece> shaped_;
  PathTicks shaped_end_ = 0;
  std::uint64_t planned_pieces_ = 0;
  std::deque<ContourTrack::Piece> pieces_;  ///< pieces to be published when there is room
  std::deque<ContourTrack::Event> events_;  ///< events to be published when there is room
  std::uint64_t planned_events_ = 0;
  std::optional<Curved> gathered_;      ///< short stretches that may still merge with the next one
  std::vector<Curved> curved_;          ///< stretches whose limits may still change
  std::size_t first_curved_ = 0;        ///< earlier elements have been passed on
  double curved_brakes2_ = 0.0;         ///< sum of the squared speed that all of them can take away by braking
  double reached2_ = 0.0;               ///< square of the highest reachable speed after them
  std::deque<Stretch> open_;            ///< stretches with their own limits, which may still be lowered
  SteppedLimit tops_;                   ///< speed limits from open_ on, neighbouring stretches included
  SteppedLimit accelerations_;          ///< acceleration limits, likewise
  std::deque<Stretch> settled_;         ///< stretches to be published
  std::optional<PathTicks> early_end_;  ///< end of a stretch that was settled early for lack of room
  std::vector<double> lengths_;         ///< lengths of the last pieces, a ring
  std::size_t next_length_ = 0;
  double sum_of_lengths_ = 0.0;
  double reverse2_ = 0.0;  ///< `behind2` of the next cell
  double brakes2_ = 0.0;   ///< `brakes2` of the next cell
  double last_top_ = 0.0;  ///< `top` of the last published cell
};

}  // namespace driveline::trajectory
