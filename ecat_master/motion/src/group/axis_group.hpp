#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/motion/group/group_request.hpp"
#include "driveline/motion/single_axis/setpoint_feed.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/rt/triple_buffer.hpp"
#include "group_path.hpp"
#include "group_request_table.hpp"
#include "group_stops.hpp"

namespace driveline::motion {

/// A request in the queue to the cycle.
struct NumberedGroupRequest {
  std::uint64_t id = 0;    ///< number from GroupRequestTable::add()
  GroupRequest request{};  ///< the request
};

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

  /// Numbers of requests: those in the queue, and those in the lane of stops.
  struct Count {
    std::uint64_t queued = 0;
    std::uint64_t stops = 0;
  };

  // Functions for submitting threads, one at a time.
  /// Submits a request and returns its number; 0: the queue is full. A stop, a halt, an interrupt and a disable are
  /// taken by the next cycle, whatever is queued.
  [[nodiscard]] std::uint64_t submit(const GroupRequest& request) noexcept;
  /// Number of requests that have been submitted.
  [[nodiscard]] Count submitted() const noexcept { return {queued_, stops_.puts()}; }

  // Functions for planning, one thread at a time.
  /// Whether the cycle has taken this many requests.
  [[nodiscard]] bool has_taken(const Count& count) const noexcept {
    return taken_.load(std::memory_order_acquire) >= count.queued &&
           stops_taken_.load(std::memory_order_acquire) >= count.stops;
  }
  /// Offers a path to the cycle, one at a time; take_back() returns it when the axes have left it.
  void offer(GroupPath* path) noexcept { offered_.store(path, std::memory_order_release); }
  /// Returns a path that the axes have left; null: none.
  [[nodiscard]] GroupPath* take_back() noexcept;
  /// Ends the path under way in favour of the move with this number; the axes come to rest on it.
  void abort_for(std::uint64_t id) noexcept { abort_for_.store(id, std::memory_order_release); }
  /// The last standstill at which a path may start.
  [[nodiscard]] const Standing& standing() noexcept;
  /// Moves with smaller request numbers have been aborted.
  [[nodiscard]] std::uint64_t dropped_below() const noexcept { return dropped_below_.load(std::memory_order_acquire); }
  /// Paths of this epoch and earlier ones get no more moves.
  [[nodiscard]] std::uint64_t ended_epoch() const noexcept { return ended_epoch_.load(std::memory_order_acquire); }
  /// Number of cycles for which the axes have been at the end of the planned path.
  [[nodiscard]] std::uint64_t cycles_at_end() const noexcept { return cycles_at_end_.load(std::memory_order_acquire); }
  /// Any thread.
  [[nodiscard]] GroupReport report() const noexcept;
  [[nodiscard]] GroupState state() const noexcept { return shared_state_.load(std::memory_order_acquire); }

  // Functions for the cycle: SetpointFeed.
  [[nodiscard]] std::size_t axis_count() const noexcept override { return members_.size(); }
  void begin_cycle() noexcept override;
  [[nodiscard]] bool take(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept override;
  void join(std::size_t axis, const trajectory::AxisSetpoint& from) noexcept override;
  void leave(std::size_t axis) noexcept override;
  [[nodiscard]] bool next(double period_s, std::span<trajectory::AxisSetpoint> setpoints) noexcept override;
  [[nodiscard]] bool waits() const noexcept override { return path_ != nullptr && leads(); }
  [[nodiscard]] bool keeps_ranges() const noexcept override { return true; }

 private:
  /// A client's request to an axis that waits until the group is at standstill.
  struct Asked {
    std::uint64_t id = 0;
    AxisRequest request{};
  };

  void take_path() noexcept;
  void take_stops() noexcept;
  void take_requests() noexcept;
  void take(std::uint64_t id, const GroupRequest& request) noexcept;
  [[nodiscard]] bool overtaken(const NumberedGroupRequest& request) noexcept;
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
  void step() noexcept;
  void publish() noexcept;
  [[nodiscard]] bool leads() const noexcept { return state_ != GroupState::kDisabled && !releasing_; }

  SingleAxes& axes_;
  std::vector<std::size_t> members_;
  GroupRequestTable& table_;
  GroupState state_ = GroupState::kDisabled;
  std::vector<trajectory::AxisSetpoint> setpoints_;
  std::vector<std::uint64_t> follow_requests_;
  std::vector<std::uint64_t> reset_requests_;
  std::vector<Asked> asked_;
  std::size_t joined_ = 0;
  bool enabling_ = false;
  bool releasing_ = false;  ///< the axes are being released
  bool ending_ = false;     ///< the path ends where the axes come to rest
  bool interrupted_ = false;
  bool backwards_ = false;
  double override_ = 1.0;
  GroupPath* path_ = nullptr;
  GroupPath::Place place_{};
  std::uint64_t completed_ = 0;    ///< completed() of the path before its last step
  std::uint64_t active_move_ = 0;  ///< moves with smaller numbers have been reported as active
  std::uint64_t taken_now_ = 0;    ///< number of requests taken from the queue
  std::uint64_t at_end_for_ = 0;   ///< cycles at the end of the planned path
  Standing standing_{};
  GroupError error_ = GroupError::kNone;
  std::size_t failed_axis_ = 0;  ///< number of the axis on the line
  AxisError axis_error_ = AxisError::kNone;
  std::uint16_t error_code_ = 0;
  // Numbers of requests; 0: none.
  std::uint64_t enable_request_ = 0;
  std::uint64_t disable_request_ = 0;
  std::uint64_t stop_request_ = 0;
  std::uint64_t halt_request_ = 0;
  std::uint64_t interrupt_request_ = 0;
  std::uint64_t reset_request_ = 0;

  rt::SpscRing<NumberedGroupRequest> requests_;
  std::uint64_t queued_ = 0;  ///< requests put into requests_; used by submitting threads
  GroupStopLane stops_{1};
  rt::SpscRing<GroupPath*> returned_;
  rt::TripleBuffer<Standing> standings_{};
  std::atomic<GroupPath*> offered_{nullptr};
  std::atomic<std::uint64_t> abort_for_{0};
  std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> stops_taken_{0};
  std::atomic<std::uint64_t> dropped_below_{0};
  std::atomic<std::uint64_t> ended_epoch_{0};
  std::atomic<std::uint64_t> cycles_at_end_{0};
  std::atomic<GroupState> shared_state_{GroupState::kDisabled};
  std::atomic<GroupError> shared_error_{GroupError::kNone};
  std::atomic<std::size_t> shared_failed_axis_{0};
  std::atomic<AxisError> shared_axis_error_{AxisError::kNone};
  std::atomic<std::uint16_t> shared_error_code_{0};
  std::atomic<double> shared_override_{1.0};
  std::atomic<double> shared_speed_{0.0};
  std::atomic<double> shared_length_{0.0};
  std::atomic<std::uint64_t> shared_move_{0};
  std::atomic<bool> shared_interrupted_{false};
  std::atomic<bool> shared_backwards_{false};
};

}  // namespace driveline::motion
