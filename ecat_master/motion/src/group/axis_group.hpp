#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/motion/group/group_request.hpp"
#include "driveline/motion/single_axis/setpoint_feed.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/rt/published_value.hpp"
#include "driveline/rt/triple_buffer.hpp"
#include "followed_path.hpp"
#include "group_inbox.hpp"
#include "group_path.hpp"
#include "group_request_table.hpp"
#include "path_exchange.hpp"

namespace driveline::motion {

/// Cycle side of a group: its states, its requests except moves, and the setpoints of its axes along the path that
/// planning provides.
class AxisGroup final : public SetpointFeed {
 public:
  /// Positions of the axes at standstill, where a path can start.
  struct Standing {
    std::uint64_t epoch = 0;  ///< number of this standstill; 0: none yet
    std::array<double, AxisGroups::kMaxAxes> at{};
    std::array<double, AxisGroups::kMaxAxes> offsets{};  ///< SingleAxis::position_offset(), while the axes are led
  };

  /// To be called before the cycle starts; `axes` and `table` must outlive this object.
  AxisGroup(SingleAxes& axes, std::vector<std::size_t> members, GroupRequestTable& table);

  using Count = GroupInbox::Count;  ///< see GroupInbox

  // Functions for submitting threads, one at a time; see GroupInbox.
  [[nodiscard]] std::uint64_t submit(const GroupRequest& request) noexcept { return inbox_.submit(request); }
  [[nodiscard]] Count submitted() const noexcept { return inbox_.submitted(); }

  // Functions for planning, one thread at a time.
  /// Whether the cycle has taken this many requests.
  [[nodiscard]] bool has_taken(const Count& count) const noexcept { return inbox_.has_taken(count); }
  /// Paths to the cycle and back.
  [[nodiscard]] PathExchange& paths() noexcept { return paths_; }
  /// The last standstill at which a path may start.
  [[nodiscard]] const Standing& standing() noexcept;
  /// Any thread but that of the cycle.
  [[nodiscard]] GroupReport report() const noexcept { return report_.read(); }
  [[nodiscard]] GroupState state() const noexcept { return report_.read().state; }

  // Functions for the cycle: SetpointFeed.
  [[nodiscard]] std::size_t axis_count() const noexcept override { return members_.size(); }
  void begin_cycle() noexcept override;
  [[nodiscard]] bool take(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept override;
  void join(std::size_t axis, const trajectory::AxisSetpoint& from) noexcept override;
  void leave(std::size_t axis) noexcept override;
  [[nodiscard]] bool next(double period_s, std::span<trajectory::AxisSetpoint> setpoints) noexcept override;
  [[nodiscard]] bool waits() const noexcept override { return followed_.there() && leads(); }
  [[nodiscard]] bool keeps_ranges() const noexcept override { return true; }

 private:
  /// A client's request to an axis that waits until the group is at standstill.
  struct Asked {
    std::uint64_t id = 0;
    AxisRequest request{};
  };

  void take_path() noexcept;
  void take(std::uint64_t id, const GroupRequest& request) noexcept;
  [[nodiscard]] GroupError refusal(const GroupRequest& request) const noexcept;
  void take_enable(std::uint64_t id) noexcept;
  void take_stop(std::uint64_t id) noexcept;
  void take_halt(std::uint64_t id) noexcept;
  void take_disable(std::uint64_t id) noexcept;
  void take_reset(std::uint64_t id) noexcept;
  void take_interrupt(std::uint64_t id) noexcept;
  void take_direction(std::uint64_t id, bool backwards) noexcept;
  void release_stop() noexcept;
  void stop_for(std::size_t place, std::uint64_t request, const AxisRequest& asked) noexcept;
  [[nodiscard]] GroupError refusal_by_state(GroupCommand command) const noexcept;
  [[nodiscard]] GroupError refusal_of(std::size_t place) const noexcept;
  void let_go(std::size_t places) noexcept;
  void watch() noexcept;
  void fail(std::size_t axis) noexcept;
  void judge_path() noexcept;
  void judge_rest() noexcept;
  void judge_reset() noexcept;
  void end_path(std::uint64_t dropped_below, GroupError error, std::size_t axis) noexcept;
  void stand() noexcept;
  void release() noexcept;
  void answer_asked(bool released) noexcept;
  void finish(std::uint64_t& id, RequestPhase phase, GroupError error = GroupError::kNone,
              std::size_t axis = 0) noexcept;
  void begin(std::uint64_t& place, std::uint64_t id) noexcept;
  void set_hold() noexcept;
  void publish() noexcept;
  [[nodiscard]] bool leads() const noexcept { return state_ != GroupState::kDisabled && !releasing_; }

  /// Numbers of the requests that are not done yet; 0: none.
  struct Pending {
    std::uint64_t enable = 0;
    std::uint64_t disable = 0;
    std::uint64_t stop = 0;
    std::uint64_t halt = 0;
    std::uint64_t interrupt = 0;
    std::uint64_t reset = 0;
  };
  /// Reason for GroupErrorStop.
  struct Failure {
    GroupError error = GroupError::kNone;
    std::size_t axis = 0;  ///< number of the axis on the line
    AxisError axis_error = AxisError::kNone;
    std::uint16_t error_code = 0;
  };

  SingleAxes& axes_;
  std::vector<std::size_t> members_;
  GroupRequestTable& table_;
  GroupInbox inbox_;
  PathExchange paths_;
  FollowedPath followed_;
  GroupState state_ = GroupState::kDisabled;
  std::vector<trajectory::AxisSetpoint> setpoints_;
  std::vector<std::uint64_t> follow_requests_;
  std::vector<std::uint64_t> reset_requests_;
  std::vector<Asked> asked_;
  Pending pending_{};
  Failure failure_{};
  std::size_t joined_ = 0;
  bool enabling_ = false;
  bool releasing_ = false;  ///< the axes are being released
  bool ending_ = false;     ///< the path ends where the axes come to rest
  bool interrupted_ = false;
  bool backwards_ = false;
  double override_ = 1.0;
  Standing standing_{};
  rt::TripleBuffer<Standing> standings_{};
  rt::PublishedValue<GroupReport> report_{};
};

}  // namespace driveline::motion
