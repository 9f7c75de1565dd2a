#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/trajectory/contour_track.hpp"

namespace driveline::trajectory {

/// Outputs that are reported in one cycle; further ones follow in the next.
inline constexpr std::size_t kMostOutputsOfCycle = 4;

/// Where the axes of a group shall be in one cycle.
struct ContourSetpoint {
  GroupVector position{};      ///< of the axes, rad or m
  GroupVector velocity{};      ///< rad/s or m/s
  GroupVector acceleration{};  ///< rad/s² or m/s²
  GroupVector
      tool{};  ///< the place on the path in the coordinates of the moves: of a machine without kinematics the position
  std::uint64_t move = 0;  ///< number of the move that they are on, 0 is the first
  double length = 0.0;     ///< along the path since its begin, m or rad
  double speed = 0.0;      ///< along the path, m/s or rad/s, negative backwards
  bool at_rest = true;     ///< all axes stand
  /// They stand at the end of what is planned: the path is finished, or the planner has nothing.
  bool at_end = true;
  bool dwells = false;                                    ///< they stand because a move says so
  std::size_t changes = 0;                                ///< so many of `changed`
  std::array<PathOutput, kMostOutputsOfCycle> changed{};  ///< outputs of this cycle, see changed_outputs()

  /// Outputs whose places the axes have passed with this cycle, in the order of the path. Each is told once: backwards
  /// there are none, and what has been passed before is not told again when the axes come back. \rtsafe
  [[nodiscard]] std::span<const PathOutput> changed_outputs() const noexcept {
    return std::span(changed).first(changes);
  }
};

/// The cycle's part of a planned path: goes along it, faster, slower, backwards or not at all, always on the path and
/// always within the limits of the axes, whatever is asked for and when. What is asked for takes effect with the next
/// cycle, or when the acceleration that is under way has been taken back (at most smoothing_cycles() later).
///
/// The speed along the path has an acceleration that jumps within its limits; the mean of the places of the last N
/// cycles is where the axes are told to be, so that the jerk is limited, too. See trajectory/README.md, "Along a path".
class ContourFollower {
 public:
  /// Begins at rest at the begin of `track`, which must outlive it. Allocates.
  explicit ContourFollower(ContourTrack& track);

  /// Feed, as a share of what the moves say, from 0 to kMaxOverride; 0 stops the axes on the path. False, and nothing
  /// happens: the value is out of range or not a number. \rtsafe
  bool set_override(double share) noexcept;
  /// Stops the axes on the path, or lets them go on. The time of a dwell does not run while they are held. \rtsafe
  void hold(bool held) noexcept { held_ = held; }
  /// Backwards along the path, as far as it is still known, or forwards. Dwells and outputs belong to the way forwards,
  /// and are done once. \rtsafe
  void reverse(bool backwards) noexcept { backwards_ = backwards; }
  /// The next cycle. Bounded: looks at some 40 stretches ahead. \rtsafe
  ContourSetpoint step() noexcept;

 private:
  using Cell = ContourTrack::Cell;

  [[nodiscard]] bool has_next_cell(std::uint64_t index) noexcept;
  void find_cell() noexcept;
  void find_piece() noexcept;
  void forget() noexcept;
  [[nodiscard]] double wanted_speed(const Cell& cell) const noexcept;
  [[nodiscard]] double next_speed(const Cell& cell) noexcept;
  [[nodiscard]] double allowed(double speed, double coast_s) noexcept;
  [[nodiscard]] double far_speed2(const Cell& cell, std::uint64_t index) noexcept;
  [[nodiscard]] PathTicks ticks_to_end(const Cell& cell) const noexcept;
  void advance(double speed) noexcept;
  [[nodiscard]] double local_length() noexcept;
  [[nodiscard]] const ContourTrack::Event* next_event(std::uint64_t ahead = 0) noexcept;
  [[nodiscard]] bool is_dwelling() noexcept;
  void forget_event() noexcept;
  void tell_outputs(ContourSetpoint& out) noexcept;
  [[nodiscard]] ContourSetpoint setpoint() noexcept;

  ContourTrack& track_;
  const double period_s_;
  const std::int64_t window_;  ///< cycles that are averaged
  double override_ = 1.0;
  bool held_ = false;
  bool backwards_ = false;

  // Before the averaging.
  PathTicks place_ = 0;
  double speed_ = 0.0;  ///< in the direction of the motion, >= 0
  int direction_ = 1;
  std::int64_t since_rise_;  ///< cycles since the speed (forwards is positive) rose
  std::int64_t since_fall_;  ///< and fell
  std::uint64_t cell_ = 0;
  std::uint64_t cells_known_ = 0;
  std::uint64_t event_ = 0;  ///< the next one
  std::uint64_t events_known_ = 0;
  std::uint64_t dwelt_ = 0;  ///< cycles
  bool dwells_ = false;

  // The averaging.
  std::vector<PathTicks> places_;  ///< of the last cycles, a ring
  std::vector<double> speeds_;     ///< the same
  std::size_t oldest_ = 0;         ///< in the ring
  PathTicks lag_ = 0;              ///< sum of what is left to place_ of each of them
  std::uint64_t piece_ = 0;
  std::uint64_t pieces_known_ = 0;
  double mean_speed_ = 0.0;
  double mean_acceleration_ = 0.0;
  PathGeometry joints_;  ///< of the last cycle
};

}  // namespace driveline::trajectory
