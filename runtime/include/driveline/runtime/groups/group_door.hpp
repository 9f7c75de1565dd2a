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

#include "driveline/ecat_master/group/axis_groups.hpp"
#include "driveline/runtime/axes/axis_door.hpp"
#include "driveline/runtime/config/axis_group_config.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/groups/group_way.hpp"

namespace driveline::runtime {

/// How far a request to a group, or a move of it, is.
struct GroupProgress {
  ecat_master::GroupRequestReport report;  ///< phase and reason
  std::optional<GroupRefusal> refusal{};   ///< the reason with its facts; none: it has not failed
};

/// What a group does, and who commands it.
struct GroupStatus {
  WayLimits limits;                                  ///< name, axes, and how far they may go
  std::string owner;                                 ///< of its axes; empty: nobody, or not one for all
  std::optional<ecat_master::GroupReport> report{};  ///< none: the line does not run
  std::vector<double> setpoint{};                    ///< of each axis, rad or m, as requests count; empty likewise
  /// Of each coordinate of its moves: where the tool is told to be, without a machine the axes; empty likewise, or the
  /// machine cannot be as its joints stand.
  std::vector<double> place{};
  std::size_t room = 0;  ///< so many moves would be taken now
};

/// Moves of a path that have been taken: numbers to ask progress() with.
struct TakenMoves {
  std::uint64_t first = 0;
  std::size_t count = 0;
};

/// The way of requests to the groups of axes of a running line, beside the AxisDoor of its single axes. Who asks
/// something of a group takes the leases of all its axes, and needs them all; a halt, a stop and a hold are open to
/// everybody. The group of an owner who is not heard any more, or goes without leaving his motion to itself, comes to
/// rest on its path. Any thread but the cycle's; a lock inside.
class GroupDoor final : private GroupGuard {
 public:
  /// `axes` must outlive it, and not be used by other threads meanwhile. `groups` must outlive it.
  GroupDoor(const std::vector<AxisGroupConfig>& groups, AxisDoor& axes);
  ~GroupDoor() override;
  GroupDoor(const GroupDoor&) = delete;
  GroupDoor& operator=(const GroupDoor&) = delete;

  // The side of the line.
  /// Requests are taken from now on, until close(). Both must outlive that. `outputs`: of each group.
  void open(ecat_master::AxisGroups& groups, ecat_master::SingleAxes& axes,
            std::vector<std::vector<GroupOutputLimits>> outputs = {});
  /// The line goes out of operation.
  void close();
  /// Events since the last call, in order.
  [[nodiscard]] std::vector<EventFacts> take_events();
  /// Why a group is in GroupErrorStop.
  [[nodiscard]] GroupRefusal refusal_of(const ecat_master::GroupReport& report) const;

  // The side of who asks.
  /// Configuration of the groups, in the order of the line description.
  [[nodiscard]] const std::vector<AxisGroupConfig>& groups() const noexcept { return configs_; }
  /// Name and axes of a group.
  [[nodiscard]] events::EventGroup event_group(std::size_t group) const;
  /// Hands on a request: the number to ask progress() with.
  [[nodiscard]] tl::expected<std::uint64_t, GroupRefusal> submit(const AxisCaller& caller, std::size_t group,
                                                                 const GroupRequest& request);
  /// Hands on the next moves of a path, as many as there is room for. `begins`: the first of them begins the path; the
  /// others go on from those before. `ends`: the last one is the end of the path. A feed of 0 is that of the group.
  /// What is refused is the move after those that were taken; nothing is taken where that is the first one.
  [[nodiscard]] tl::expected<TakenMoves, GroupRefusal> add_moves(const AxisCaller& caller, std::size_t group,
                                                                 std::span<const trajectory::PathMove> moves,
                                                                 bool begins, bool ends);
  /// How far a request, or a move, is.
  [[nodiscard]] GroupProgress progress(std::size_t group, std::uint64_t request) const;
  /// The group as of now.
  [[nodiscard]] GroupStatus status(std::size_t group) const;
  /// Before AxisDoor::leave(): `stop`: groups that his requests move come to rest.
  void leave(const std::string& caller, bool stop);
  /// Gives the axes of a group back.
  void release(const std::string& caller, std::size_t group);
  /// Notes requests that have failed. To be called every few milliseconds.
  void watch();

 private:
  struct Group;
  /// A request, or moves one behind the other, that were not over at the last watch().
  struct Pending {
    std::uint64_t number = 0;  ///< of the first one that is not over
    std::uint64_t last = 0;
    std::size_t group = 0;
    AxisCaller caller;
    std::optional<GroupRequest> request{};  ///< none: moves of a path
  };
  using Refused = std::optional<GroupRefusal>;

  bool bring_to_rest(std::size_t axis) override;
  [[nodiscard]] bool waits_for(const std::string& caller) override;
  [[nodiscard]] tl::expected<std::uint64_t, GroupRefusal> try_to_submit(const AxisCaller& caller, std::size_t group,
                                                                        const GroupRequest& request);
  [[nodiscard]] tl::expected<std::uint64_t, GroupRefusal> try_to_move(std::size_t group, const GroupRequest& request);
  [[nodiscard]] tl::expected<TakenMoves, GroupRefusal> try_to_add(const AxisCaller& caller, std::size_t group,
                                                                  std::span<const trajectory::PathMove> moves,
                                                                  bool begins, bool ends);
  [[nodiscard]] Refused take(const AxisCaller& caller, std::size_t group);
  [[nodiscard]] Refused foreign(const AxisCaller& caller, std::size_t axis) const;
  [[nodiscard]] bool broken(std::size_t group, const AxisCaller& caller) const;
  [[nodiscard]] Refused moved_together(std::size_t group) const;
  [[nodiscard]] GroupRefusal of_group(std::size_t group, const ecat_master::GroupRequestReport& report,
                                      std::uint64_t request) const;
  [[nodiscard]] GroupProgress progress_of(std::size_t group, std::uint64_t request) const;
  [[nodiscard]] WayLimits limits_of(std::size_t group) const;
  [[nodiscard]] std::vector<double> joints_of(std::size_t group) const;
  [[nodiscard]] std::vector<double> place_of(std::size_t group) const;
  [[nodiscard]] bool rests(std::size_t group) const;
  void find_place(std::size_t group);
  [[nodiscard]] Refused check_move(std::size_t group, const ecat_master::GroupMove& move, bool goes_on);
  void halt(std::size_t group);

  const std::vector<AxisGroupConfig>& configs_;
  AxisDoor& door_;
  mutable std::mutex lock_;
  ecat_master::AxisGroups* running_ = nullptr;
  ecat_master::SingleAxes* single_ = nullptr;
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<std::vector<GroupOutputLimits>> outputs_;  ///< of each group of a running line
  std::vector<Pending> pending_;
  std::vector<EventFacts> events_;
};

}  // namespace driveline::runtime
