#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/config/axis_group_config.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/runtime/event/group_events.hpp"
#include "driveline/runtime/groups/group_moves.hpp"

namespace driveline::runtime {

/// Progress of a request to a group, or of a single move.
struct GroupProgress {
  motion::GroupRequestReport report;      ///< phase and reason
  std::optional<GroupRefusal> refusal{};  ///< reason with its facts; none: the request has not failed
  /// The group has accepted the request: a move is planned, and may still wait for its turn, or be over.
  bool accepted = false;
};

/// State of a group, and its owner.
struct GroupStatus {
  MoveLimits limits;                            ///< name, axes and limits
  std::string owner;                            ///< owner of all its axes; empty: none, or several
  std::optional<motion::GroupReport> report{};  ///< none: the line is not running
  /// Setpoint of each axis, rad or m, as requests count; empty: the line is not running.
  std::vector<double> setpoint{};
  /// Commanded position in each coordinate of its moves: of the tool, or of the axes without a machine. Empty: the line
  /// is not running, or the machine has no solution for its present joints.
  std::vector<double> place{};
  std::size_t room = 0;  ///< number of moves that would be accepted now
};

/// Numbers of the accepted moves of a path, for progress().
struct TakenMoves {
  std::uint64_t first = 0;
  std::size_t count = 0;
};

/// Interface for requests to the axis groups of a running line, next to the AxisRequests of its single axes. A request
/// to a group needs the leases of all its axes, and takes them; any client may send a halt, a stop or a hold. The group
/// of an owner that is silent, or that leaves without letting its motion finish, comes to rest on its path. Any thread
/// except the cycle's; uses locks, but no stop waits for the check of a move or for its planning. Moves that are being
/// checked when a stop comes are refused.
class GroupRequests final : private GroupGuard {
 public:
  /// `axes` must outlive it, and other threads must not use `axes` during construction and destruction. `groups` must
  /// outlive it.
  GroupRequests(const std::vector<AxisGroupConfig>& groups, AxisRequests& axes);
  ~GroupRequests() override;
  GroupRequests(const GroupRequests&) = delete;
  GroupRequests& operator=(const GroupRequests&) = delete;

  // Called by the line.
  /// Accepts requests from now on, until close(). Both must live until then. `outputs`: outputs of each group.
  void open(motion::AxisGroups& groups, motion::SingleAxes& axes,
            std::vector<std::vector<GroupOutputLimits>> outputs = {});
  /// Ends the acceptance of requests: the line goes out of operation.
  void close();
  /// Returns the events since the last call, oldest first.
  [[nodiscard]] std::vector<EventFacts> take_events();
  /// Returns why a group is in GroupErrorStop.
  [[nodiscard]] GroupRefusal refusal_of(const motion::GroupReport& report) const;

  // Called by clients.
  /// Returns the configuration of the groups, in the order of the line description.
  [[nodiscard]] const std::vector<AxisGroupConfig>& groups() const noexcept { return configs_; }
  /// Returns name and axes of a group.
  [[nodiscard]] events::EventGroup event_group(std::size_t group) const;
  /// Forwards a request to the group. Returns its number for progress().
  [[nodiscard]] tl::expected<std::uint64_t, GroupRefusal> submit(const AxisCaller& caller, std::size_t group,
                                                                 const ClientGroupRequest& request);
  /// Forwards the next moves of a path, as many as there is room for. `begins`: the first of them starts the path;
  /// otherwise they continue the preceding moves. `ends`: the last one ends the path. A feed of 0 is the default feed
  /// of the group. A refusal concerns the first move that was not accepted; it is returned only if no move was
  /// accepted.
  [[nodiscard]] tl::expected<TakenMoves, GroupRefusal> add_moves(const AxisCaller& caller, std::size_t group,
                                                                 std::span<const trajectory::PathMove> moves,
                                                                 bool begins, bool ends);
  /// Returns the progress of a request or a move.
  [[nodiscard]] GroupProgress progress(std::size_t group, std::uint64_t request) const;
  /// Returns the present state of the group.
  [[nodiscard]] GroupStatus status(std::size_t group) const;
  /// Call before AxisRequests::leave(). `stop`: brings the groups that the caller's requests move to rest.
  void leave(const std::string& caller, bool stop);
  /// Releases the axes of a group.
  void release(const std::string& caller, std::size_t group);
  /// Reports requests that have failed. Call every few milliseconds.
  void watch();

 private:
  struct Group;
  struct MoveCheck;
  using Guard = std::unique_lock<std::mutex>;  ///< holds lock_
  /// A request, or consecutive moves, that were not over at the last watch().
  struct Pending {
    std::uint64_t number = 0;  ///< first number that is not over
    std::uint64_t last = 0;
    std::size_t group = 0;
    AxisCaller caller;
    std::optional<ClientGroupRequest> request{};  ///< none: moves of a path
  };
  using Refused = std::optional<GroupRefusal>;

  bool bring_to_rest(std::size_t axis) override;
  [[nodiscard]] bool waits_for(const std::string& caller) override;
  [[nodiscard]] tl::expected<std::uint64_t, GroupRefusal> try_to_submit(const AxisCaller& caller, std::size_t group,
                                                                        const ClientGroupRequest& request,
                                                                        Guard& guard);
  [[nodiscard]] tl::expected<std::uint64_t, GroupRefusal> try_to_move(std::size_t group,
                                                                      const ClientGroupRequest& request, Guard& guard);
  [[nodiscard]] tl::expected<TakenMoves, GroupRefusal> try_to_add(const AxisCaller& caller, std::size_t group,
                                                                  std::span<const trajectory::PathMove> moves,
                                                                  bool begins, bool ends, Guard& guard);
  [[nodiscard]] Refused take(const AxisCaller& caller, std::size_t group);
  [[nodiscard]] Refused foreign(const AxisCaller& caller, std::size_t axis) const;
  [[nodiscard]] bool broken(std::size_t group, const AxisCaller& caller) const;
  [[nodiscard]] Refused moved_together(std::size_t group) const;
  [[nodiscard]] GroupRefusal of_group(std::size_t group, const motion::GroupRequestReport& report,
                                      std::uint64_t request) const;
  [[nodiscard]] GroupProgress progress_of(std::size_t group, std::uint64_t request) const;
  [[nodiscard]] bool is_move(std::uint64_t request) const;
  [[nodiscard]] MoveLimits limits_of(std::size_t group) const;
  [[nodiscard]] std::vector<double> joints_of(std::size_t group) const;
  [[nodiscard]] std::vector<double> place_of(std::size_t group) const;
  [[nodiscard]] bool rests(std::size_t group) const;
  void find_place(std::size_t group);
  [[nodiscard]] MoveCheck begin_check(std::size_t group) const;
  [[nodiscard]] static Refused check_move(MoveCheck& check, const motion::GroupMove& move, bool goes_on);
  [[nodiscard]] Refused end_check(std::size_t group, const MoveCheck& check);
  void end_path(std::size_t group);
  void halt(std::size_t group);

  const std::vector<AxisGroupConfig>& configs_;
  AxisRequests& axis_requests_;
  std::mutex moves_lock_;    ///< serialises callers with moves, which check them without lock_; locked before lock_
  mutable std::mutex lock_;  ///< never held while moves are checked or planned
  motion::AxisGroups* running_ = nullptr;
  motion::SingleAxes* single_ = nullptr;
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<std::vector<GroupOutputLimits>> outputs_;  ///< outputs of each group of a running line
  std::vector<Pending> pending_;
  std::vector<EventFacts> events_;
};

}  // namespace driveline::runtime
