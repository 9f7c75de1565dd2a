#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/group/group_request.hpp"
#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/trajectory/contour_settings.hpp"

namespace driveline::ecat_master {

/// What is told of the outputs of moves (trajectory::PathMove::outputs), in the cycle in which the axes pass their
/// places.
class PathOutputs {
 public:
  virtual ~PathOutputs() = default;
  /// An output of a group changes. \rtsafe
  virtual void change(const trajectory::PathOutput& output) noexcept = 0;

 protected:
  PathOutputs() = default;
  /// Copying is for implementations only.
  PathOutputs(const PathOutputs&) = default;
  PathOutputs& operator=(const PathOutputs&) = default;
};

/// Some axes of a line that move together along paths.
struct GroupConfig {
  std::string name;                 ///< for messages
  std::vector<std::size_t> axes{};  ///< by their numbers, in the order of the coordinates; an axis is in one group
  /// Memory of the path, of groups of up to trajectory::kMaxGroupAxes axes: see trajectory::ContourSettings::capacity.
  std::size_t capacity = 4096;
  /// Time in which an axis without AxisConfig::max_jerk gets to its highest acceleration.
  double jerk_time_s = 0.02;
  /// Of a machine whose axes are not the coordinates of its moves: the axes are its joints, in its order, and what is
  /// behind them. Up to trajectory::kMaxGroupAxes axes; must outlive the groups. Null: moves are in the positions of
  /// the axes.
  const trajectory::Kinematics* kinematics = nullptr;
  trajectory::ToolLimits tool{};   ///< of the point on the path; with `kinematics` it needs a velocity limit
  PathOutputs* outputs = nullptr;  ///< must outlive the groups; null: moves with outputs are refused
};

/// Axes of a line that is commanded axis by axis (SingleAxes), moved together along paths: groups as PLCopen part 4 has
/// them. An enabled group leads its axes, which are in SynchronizedMotion, also while they stand; they refuse requests
/// of their own (AxisError::kInGroup), but a stop, a halt and the end of their power, which bring the group to rest
/// first, and touch probes.
///
/// A group of up to trajectory::kMaxGroupAxes axes follows lines, arcs and splines with rounded corners
/// (trajectory::ContourPlanner). One of more axes, up to kMostAxes, follows straight lines, and stops between them.
///
/// All axes keep their limits, of which a group uses somewhat less than all (kShareOfVelocity,
/// kShareOfAcceleration): the rest is for axes that come back to the path after frames were lost. When an axis fails,
/// the others come to rest on the path, within their limits, and the group is in GroupErrorStop.
///
/// Planning is done beside the cycle, in plan(): by a thread of its own (start_planning()), or by whoever owns the
/// virtual time.
class AxisGroups {
 public:
  /// The most axes of a group.
  static constexpr std::size_t kMostAxes = 128;
  /// Moves of a group that may wait to be planned.
  static constexpr std::size_t kMostMoves = 256;
  /// Of the velocity limits of the axes, that paths ask for at most.
  static constexpr double kShareOfVelocity = 0.98;
  /// The same of the acceleration.
  static constexpr double kShareOfAcceleration = 0.85;

  /// Before the cycle starts; `axes` must outlive it, and it the cycle. The axes of groups have no other feed.
  /// @throws std::invalid_argument, with a sentence that names group and axis: an axis that is not there, is twice in a
  /// group or in two, or has limits that cannot be planned with; a group without axes, without a name, or with the name
  /// of another one.
  AxisGroups(SingleAxes& axes, std::vector<GroupConfig> groups, std::chrono::nanoseconds period);
  ~AxisGroups();
  AxisGroups(const AxisGroups&) = delete;
  AxisGroups& operator=(const AxisGroups&) = delete;

  // Any thread but the cycle's.
  /// As they were given.
  [[nodiscard]] const std::vector<GroupConfig>& groups() const noexcept { return configs_; }
  /// Hands a request to a group; it is taken in the next cycle. The number to ask report() with; 0: there is no such
  /// group, or more requests than the cycle can take.
  [[nodiscard]] std::uint64_t submit(std::size_t group, const GroupRequest& request);
  /// Hands a move to a group, as submit(). Moves and requests are taken in the order in which they were handed over.
  [[nodiscard]] std::uint64_t move(std::size_t group, const GroupMove& move);
  /// A path: several moves at once, all of which are taken, or none, with 0. The number of the first one; the others
  /// count on. All but the last continue (GroupMove::continues), and all but the first are blended or, where they say
  /// so, buffered. A path without end is handed over in parts, as there is room; `room()` moves at a time.
  [[nodiscard]] std::uint64_t move_path(std::size_t group, std::span<const GroupMove> moves);
  /// So many moves would be taken now.
  [[nodiscard]] std::size_t room(std::size_t group) const;
  /// How far a request or a move is. A move is kActive from where it begins to where it ends; 4,096 of them are
  /// remembered.
  [[nodiscard]] GroupRequestReport report(std::uint64_t request) const noexcept;
  /// Why a move was refused, as a sentence without a full stop; empty: it was not, or more than 64 were since.
  [[nodiscard]] std::string refusal(std::uint64_t request) const;
  /// State of a group as of the last cycle; its figures may be of two cycles. Of a group that there is not: disabled.
  [[nodiscard]] GroupReport group_report(std::size_t group) const noexcept;

  /// Plans what has been asked for, as far as there is room; to be called every few milliseconds, by one thread or
  /// several. Allocates, and waits for submitting threads.
  void plan();
  /// A thread of this object calls plan() from now on, until it is destroyed or stop_planning() is called.
  void start_planning(std::chrono::milliseconds interval = std::chrono::milliseconds{1});
  /// Ends that thread. plan() may be called by others again.
  void stop_planning();

 private:
  class Group;
  class Worker;
  struct Shared;

  std::vector<GroupConfig> configs_;
  std::unique_ptr<Shared> shared_;
  std::vector<std::unique_ptr<Group>> groups_;
  std::unique_ptr<Worker> worker_;
};

}  // namespace driveline::ecat_master
