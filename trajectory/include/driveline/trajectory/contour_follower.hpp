#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/trajectory/contour_track.hpp"

namespace driveline::trajectory {

/// Maximum number of outputs reported in one cycle; further ones are reported in the next cycle.
inline constexpr std::size_t kMaxOutputsOfCycle = 4;

/// Setpoints of the axes of a group for one cycle.
struct ContourSetpoint {
  GroupVector position{};      ///< positions of the axes, rad or m
  GroupVector velocity{};      ///< velocities of the axes, rad/s or m/s
  GroupVector acceleration{};  ///< accelerations of the axes, rad/s² or m/s²
  GroupVector tool{};  ///< position on the path in the coordinates of the moves; equals `position` without kinematics
  std::uint64_t move = 0;  ///< number of the current move, from 0
  double length = 0.0;     ///< length along the path since its start, m or rad
  double speed = 0.0;      ///< speed along the path, m/s or rad/s; negative: backwards
  bool at_rest = true;     ///< all axes are at standstill
  /// The axes are at standstill at the end of the planned path: the path is finished, or nothing is planned.
  bool at_end = true;
  bool dwells = false;                                   ///< the axes are at standstill because of a dwell
  std::size_t changes = 0;                               ///< number of valid elements in `changed`
  std::array<PathOutput, kMaxOutputsOfCycle> changed{};  ///< outputs of this cycle, see changed_outputs()

  /// Outputs whose positions on the path the axes have passed in this cycle, in path order. Each output is reported
  /// once: never on the way backwards, and not again when the axes return. \rtsafe
  [[nodiscard]] std::span<const PathOutput> changed_outputs() const noexcept {
    return std::span(changed).first(changes);
  }
};

/// The cyclic part of a planned path: moves the axes along it faster, slower, backwards or not at all, always on the
/// path and always within the limits of the axes, whatever is requested and when. A request takes effect in the next
/// cycle, or after the present acceleration has been reduced to zero (at most smoothing_cycles() later).
///
/// The speed along the path has a bounded acceleration that may jump. The position setpoint is the mean of the path
/// positions of the last N cycles, which bounds the jerk as well. See trajectory/README.md, "Along a path".
class ContourFollower {
 public:
  /// Starts at rest at the start of `track`, which must outlive it. Allocates.
  explicit ContourFollower(ContourTrack& track);

  /// Sets the feed override, from 0 to kMaxOverride times the feed of the moves; 0 stops the axes on the path. Returns
  /// false, without effect, if the value is out of range or NaN. \rtsafe
  bool set_override(double share) noexcept;
  /// Stops the axes on the path, or lets them continue. The time of a dwell does not elapse while they are held.
  /// \rtsafe
  void hold(bool held) noexcept { held_ = held; }
  /// Selects the direction: backwards along the path, as far as it is still stored, or forwards. Dwells and outputs are
  /// executed only on the way forwards, and once. \rtsafe
  void reverse(bool backwards) noexcept { backwards_ = backwards; }
  /// Computes the setpoints of the next cycle. Bounded: checks about 40 stretches ahead. \rtsafe
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
  const std::int64_t window_;  ///< number of cycles in the average
  double override_ = 1.0;
  bool held_ = false;
  bool backwards_ = false;

  // State before averaging.
  PathTicks place_ = 0;
  double speed_ = 0.0;  ///< in the direction of motion, >= 0
  int direction_ = 1;
  std::int64_t since_rise_;  ///< cycles since the signed speed rose
  std::int64_t since_fall_;  ///< cycles since the signed speed fell
  std::uint64_t cell_ = 0;
  std::uint64_t cells_known_ = 0;
  std::uint64_t event_ = 0;  ///< number of the next event
  std::uint64_t events_known_ = 0;
  std::uint64_t dwelt_ = 0;  ///< elapsed cycles of the present dwell
  bool dwells_ = false;

  // State of the averaging.
  std::vector<PathTicks> places_;  ///< path positions of the last cycles, a ring
  std::vector<double> speeds_;     ///< signed speeds of the last cycles, a ring
  std::size_t oldest_ = 0;         ///< index of the oldest entry of both rings
  PathTicks lag_ = 0;              ///< sum of the distances from each entry of places_ to place_
  std::uint64_t piece_ = 0;
  std::uint64_t pieces_known_ = 0;
  double mean_speed_ = 0.0;
  double mean_acceleration_ = 0.0;
  PathGeometry joints_;  ///< joint geometry of the last cycle
};

}  // namespace driveline::trajectory
