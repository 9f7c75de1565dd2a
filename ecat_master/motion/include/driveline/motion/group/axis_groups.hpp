#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "driveline/motion/group/group_request.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/trajectory/contour_settings.hpp"

namespace driveline::motion {

/// Receiver of the outputs of moves (trajectory::PathMove::outputs), called in the cycle in which the axes pass the
/// positions of the outputs.
class PathOutputs {
 public:
  virtual ~PathOutputs() = default;
  /// Called when an output of a group changes. \rtsafe
  virtual void change(const trajectory::PathOutput& output) noexcept = 0;

 protected:
  PathOutputs() = default;
  /// Copying is for implementations only.
  PathOutputs(const PathOutputs&) = default;
  PathOutputs& operator=(const PathOutputs&) = default;
};

/// Configuration of a group: axes of a line that move together along paths.
struct AxisGroupSettings {
  std::string name;                 ///< for messages
  std::vector<std::size_t> axes{};  ///< axis numbers in the order of the coordinates; an axis is in one group at most
  /// Memory of the path for groups of up to trajectory::kMaxGroupAxes axes; see trajectory::ContourSettings::capacity.
  std::size_t capacity = 4096;
  /// Time in which an axis without AxisConfig::max_jerk reaches its maximum acceleration, s.
  double jerk_time_s = 0.02;
  /// Kinematics of a machine whose axes are not the coordinates of its moves: the axes are its joints, in the order of
  /// the machine, followed by axes that are both joint and coordinate. Up to trajectory::kMaxGroupAxes axes; must
  /// outlive the groups. Null: moves are in axis positions.
  const trajectory::Kinematics* kinematics = nullptr;
  trajectory::ToolLimits tool{};   ///< limits of the point on the path; a velocity limit is required with `kinematics`
  PathOutputs* outputs = nullptr;  ///< must outlive the groups; null: moves with outputs are refused
};

/// Groups of axes that move together along paths, on a line with single axes (SingleAxes), according to PLCopen part 4.
/// An enabled group leads its axes, which are in SynchronizedMotion, even at standstill. They refuse requests of their
/// own (AxisError::kInGroup) except touch probes and a stop, a halt or a switch-off, which first bring the group to
/// rest.
///
/// A group of up to trajectory::kMaxGroupAxes axes follows lines, arcs and splines with rounded corners
/// (trajectory::ContourPlanner). A larger group, up to kMaxAxes axes, follows straight lines and stops between them.
///
/// All axes keep their limits. A group uses somewhat less than the full limits (kShareOfVelocity,
/// kShareOfAcceleration); the rest is reserved for axes that return to the path after lost frames. If an axis fails,
/// the others come to rest on the path, within their limits, and the group is in GroupErrorStop.
///
/// Planning runs outside the cycle, in plan(): in a thread of this object (start_planning()), or called by the owner of
/// the virtual time.
class AxisGroups {
 public:
  /// Maximum number of axes in a group.
  static constexpr std::size_t kMaxAxes = 128;
  /// Maximum number of moves of a group that wait to be planned.
  static constexpr std::size_t kMaxMoves = 256;
  /// Share of the velocity limits of the axes that paths use at most.
  static constexpr double kShareOfVelocity = 0.98;
  /// Share of the acceleration limits of the axes that paths use at most.
  static constexpr double kShareOfAcceleration = 0.85;

  /// To be called before the cycle starts; `axes` must outlive this object, and this object the cycle. The axes of
  /// groups must have no other feed.
  /// @throws std::invalid_argument, with a sentence that names group and axis: an axis does not exist, is twice in a
  /// group or in two groups, or has limits that cannot be planned with; or a group has no axes, no name, or the name of
  /// another group.
  AxisGroups(SingleAxes& axes, std::vector<AxisGroupSettings> groups, std::chrono::nanoseconds period);
  ~AxisGroups();
  AxisGroups(const AxisGroups&) = delete;
  AxisGroups& operator=(const AxisGroups&) = delete;

  // Functions for any thread except that of the cycle.
  /// The configurations given to the constructor.
  [[nodiscard]] const std::vector<AxisGroupSettings>& groups() const noexcept { return configs_; }
  /// Submits a request to a group, a number below that of groups(). Returns the number for report(); 0: not submitted,
  /// because the queue is full.
  ///
  /// kStop, kHalt, kInterrupt and kDisable wait for nothing, neither for planning nor for other requests: the next
  /// cycle takes them, and there is always room for them. If another request of the same kind follows before that, the
  /// first ends as aborted. Other requests are queued, and the cycle takes some of them at a time. If a later stop
  /// overtakes a queued request to resume motion, that request ends as aborted.
  [[nodiscard]] std::uint64_t submit(std::size_t group, const GroupRequest& request);
  /// Queues a move of a group. It is planned after the moves that were queued before it, and after the cycle has taken
  /// the requests that were submitted before it. Returns the number for report(); 0: not queued, because there is no
  /// room().
  [[nodiscard]] std::uint64_t move(std::size_t group, const GroupMove& move);
  /// Queues several moves as one path: all of them, or none, then 0. Returns the number of the first move; the others
  /// have consecutive numbers. Every move except the last continues (GroupMove::continues), and every move except the
  /// first is blended or, if it says so, buffered. An endless path is queued in parts, up to room() moves at a time.
  [[nodiscard]] std::uint64_t move_path(std::size_t group, std::span<const GroupMove> moves);
  /// Number of moves that can be queued now.
  [[nodiscard]] std::size_t room(std::size_t group) const;
  /// Progress of a request or a move. A move is kActive from its start to its end; the last 4,096 are remembered.
  [[nodiscard]] GroupRequestReport report(std::uint64_t request) const noexcept;
  /// Reason why a move was refused, as a sentence without a full stop; empty if it was not, or after 64 further
  /// refusals.
  [[nodiscard]] std::string refusal(std::uint64_t request) const;
  /// State of a group as of the last cycle; its values may come from two cycles. For a group that does not exist:
  /// disabled.
  [[nodiscard]] GroupReport group_report(std::size_t group) const noexcept;

  /// Plans the queued moves as far as the paths have space; to be called every few milliseconds, by one thread or
  /// several. Allocates. Threads that submit requests do not wait for it.
  void plan();
  /// Starts a thread of this object that calls plan() until this object is destroyed or stop_planning() is called.
  void start_planning(std::chrono::milliseconds interval = std::chrono::milliseconds{1});
  /// Ends that thread. Then plan() may be called from outside again.
  void stop_planning();

 private:
  class Group;
  class Worker;
  struct Shared;

  std::vector<AxisGroupSettings> configs_;
  std::unique_ptr<Shared> shared_;
  std::vector<std::unique_ptr<Group>> groups_;
  std::unique_ptr<Worker> worker_;
};

}  // namespace driveline::motion
