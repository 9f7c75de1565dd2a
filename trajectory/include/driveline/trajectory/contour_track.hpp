#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// Length along a path in steps of 2^-40 m (or rad): differences are exact however long the path is.
using PathTicks = std::int64_t;
/// The length of a step.
inline constexpr double kPathTick = 1.0 / 1099511627776.0;

/// What the planner and the cycle share: the path as it is planned so far, from a little behind the axes on. One thread
/// plans (ContourPlanner), one follows (ContourFollower); neither waits for the other. All memory is taken at the
/// begin.
class ContourTrack {
 public:
  /// `start`: in the coordinates of the moves. Throws std::invalid_argument with the sentence of check_settings(), or
  /// of PathCheck when the machine cannot be there.
  ContourTrack(const ContourSettings& settings, const GroupVector& start);

  /// As they were given.
  [[nodiscard]] const ContourSettings& settings() const noexcept { return settings_; }
  /// Where the path begins, in the coordinates of the moves.
  [[nodiscard]] const GroupVector& start() const noexcept { return start_; }
  /// See smoothing_cycles(). \rtsafe
  [[nodiscard]] std::size_t smoothing() const noexcept { return smoothing_; }

 private:
  friend class ContourPlanner;
  friend class ContourFollower;

  /// A piece of the geometry.
  struct Piece {
    PathTicks begin = 0;
    PathTicks end = 0;
    PathPiece shape;
    std::uint64_t move = 0;
  };
  /// A stretch in which the speed along the path has constant limits. Speeds are those before the averaging.
  struct Cell {
    PathTicks begin = 0;
    PathTicks end = 0;
    double top = 0.0;           ///< highest speed, m/s
    double acceleration = 0.0;  ///< highest change of the speed, m/s²
    double feed = 0.0;          ///< wanted speed, m/s
    double behind2 = 0.0;       ///< square of the highest speed at its begin, going backwards, m²/s²
    double brakes2 = 0.0;       ///< what can be taken from the square of the speed from the begin of the path to here
    /// Square of the highest speed at its end, going forwards: whoever is not faster there can brake for all that is
    /// planned. It only ever rises, from the end of the path backwards.
    std::atomic<double> ahead2{0.0};
  };

  /// An output that changes, or a dwell.
  struct Event {
    PathTicks at = 0;
    std::uint64_t dwell_cycles = 0;  ///< 0: it is an output
    PathOutput change;
  };

  [[nodiscard]] Piece& piece(std::uint64_t index) noexcept { return pieces_[index & mask_]; }
  [[nodiscard]] Cell& cell(std::uint64_t index) noexcept { return cells_[index & mask_]; }
  [[nodiscard]] Event& event(std::uint64_t index) noexcept { return events_[index & mask_]; }

  ContourSettings settings_;
  GroupVector start_;
  GroupVector start_joints_;
  std::size_t smoothing_;
  std::uint64_t mask_;
  std::unique_ptr<Piece[]> pieces_;
  std::unique_ptr<Cell[]> cells_;
  std::unique_ptr<Event[]> events_;
  alignas(64) std::atomic<std::uint64_t> pieces_end_{0};  ///< so many have been planned
  std::atomic<std::uint64_t> cells_end_{0};
  std::atomic<std::uint64_t> events_end_{0};
  alignas(64) std::atomic<std::uint64_t> pieces_begin_{0};  ///< so many are not needed any more
  std::atomic<std::uint64_t> cells_begin_{0};
  std::atomic<std::uint64_t> events_begin_{0};
};

}  // namespace driveline::trajectory
