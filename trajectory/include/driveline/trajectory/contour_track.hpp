#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// Length along a path in steps of 2^-40 m (or rad), so that differences are exact on a path of any length.
using PathTicks = std::int64_t;
/// Length of a step in m or rad.
inline constexpr double kPathTick = 1.0 / 1099511627776.0;

/// Data shared by the planner and the cycle: the path as planned so far, starting slightly behind the axes. One thread
/// plans (ContourPlanner), one follows (ContourFollower); neither waits for the other. All memory is allocated at
/// construction.
class ContourTrack {
 public:
  /// `start`: position in the coordinates of the moves. Throws std::invalid_argument with the sentence of
  /// check_settings(), or of PathCheck if the machine cannot be at `start`.
  ContourTrack(const ContourSettings& settings, const GroupVector& start);

  /// Settings as given.
  [[nodiscard]] const ContourSettings& settings() const noexcept { return settings_; }
  /// Start of the path in the coordinates of the moves.
  [[nodiscard]] const GroupVector& start() const noexcept { return start_; }
  /// Number of cycles in the average, see smoothing_cycles(). \rtsafe
  [[nodiscard]] std::size_t smoothing() const noexcept { return smoothing_; }

 private:
  friend class ContourPlanner;
  friend class ContourFollower;

  /// A piece of the path geometry.
  struct Piece {
    PathTicks begin = 0;
    PathTicks end = 0;
    PathPiece shape;
    std::uint64_t move = 0;
  };
  /// A stretch in which the speed along the path has constant limits. All speeds apply before averaging.
  struct Cell {
    PathTicks begin = 0;
    PathTicks end = 0;
    double top = 0.0;           ///< highest speed, m/s
    double acceleration = 0.0;  ///< highest acceleration along the path, m/s²
    double feed = 0.0;          ///< requested speed, m/s
    double behind2 = 0.0;       ///< square of the highest speed at its start on the way backwards, m²/s²
    double brakes2 = 0.0;  ///< sum of the squared speed that braking can take away from the start of the path to here
    /// Square of the highest speed at its end on the way forwards: an axis group that is not faster there can brake
    /// before the end of the planned path. It only ever rises, starting from the end of the path.
    std::atomic<double> ahead2{0.0};
  };

  /// An output change or a dwell.
  struct Event {
    PathTicks at = 0;
    std::uint64_t dwell_cycles = 0;  ///< duration in cycles; 0: an output
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
  alignas(64) std::atomic<std::uint64_t> pieces_end_{0};  ///< number of planned pieces
  std::atomic<std::uint64_t> cells_end_{0};
  std::atomic<std::uint64_t> events_end_{0};
  alignas(64) std::atomic<std::uint64_t> pieces_begin_{0};  ///< number of pieces that are no longer needed
  std::atomic<std::uint64_t> cells_begin_{0};
  std::atomic<std::uint64_t> events_begin_{0};
};

}  // namespace driveline::trajectory
