#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "driveline/motion/control/motion_control.hpp"
#include "driveline/motion/single_axis/axis_request.hpp"
#include "driveline/motion/single_axis/gantry.hpp"
#include "driveline/motion/single_axis/master_signal.hpp"
#include "driveline/motion/single_axis/request_table.hpp"
#include "driveline/motion/single_axis/setpoint_feed.hpp"
#include "driveline/motion/single_axis/single_axis.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::motion {

/// State of an axis as seen by other threads. Positions are those of requests (AxisCommand::kSetPosition).
struct AxisReport {
  PlcopenState state = PlcopenState::kDisabled;
  AxisError error = AxisError::kNone;  ///< reason for ErrorStop
  std::uint16_t error_code = 0;        ///< 603Fh at the failure
  std::int8_t mode = 0;                ///< 6061h
  double setpoint = 0.0;               ///< rad or m
  double position = 0.0;               ///< actual position, rad or m
  double velocity = 0.0;               ///< actual velocity, rad/s or m/s
  double torque = 0.0;                 ///< actual torque, Nm or N
  double override_factor = 1.0;        ///< AxisCommand::kSetOverride
  double recorded_position = 0.0;  ///< position recorded by AxisCommand::kTouchProbe, named as at that time; rad or m
  std::uint64_t recorded_request = 0;  ///< number of the request that recorded it; 0: none
  double position_offset = 0.0;        ///< these positions minus those of the drive, rad or m
};

/// The axes of a line as single axes, each commanded by its own requests. A failing axis does not stop the others.
///
/// The demand to a drive obeys the limits of its axis whatever is requested and whatever fails; positions advance only
/// in cycles in which the drive received its setpoint.
class SingleAxes final : public MotionControl {
 public:
  /// Settings of all axes.
  using Settings = SingleAxis::Settings;

  /// @throws std::invalid_argument if a limit of an axis is not positive and finite, or its process data lack objects
  /// of its mode.
  SingleAxes(std::vector<Axis> axes, Settings settings);
  ~SingleAxes() override;
  SingleAxes(const SingleAxes&) = delete;
  SingleAxes& operator=(const SingleAxes&) = delete;

  /// Sets which axes may follow `feed`, by their numbers, in the order of the feed: this feed is the source for
  /// AxisCommand::kFollow. To be called before the cycle starts; the feed must outlive this object.
  /// @throws std::invalid_argument if the number of axes differs from that of the feed, or if an axis does not exist or
  /// already has a feed.
  void add_feed(SetpointFeed& feed, std::vector<std::size_t> axes);
  /// Combines two axes: requests to the leader move both, requests to the follower are refused. To be called before the
  /// cycle starts.
  /// @throws std::invalid_argument if an axis does not exist, or already has a feed or belongs to a gantry.
  void add_gantry(const GantrySettings& settings);
  /// Adds a signal that is read in every cycle, before any feed. To be called before the cycle starts.
  void add_signal(MasterSignal& signal) { signals_.push_back(&signal); }

  // Any thread.
  /// Submits a request to an axis, a number below that of axes(). Returns the number for report(); 0: not submitted,
  /// because the queue is full.
  ///
  /// A stop, a halt and a switch-off wait for nothing: the next cycle takes them, and there is always room for them. If
  /// another request of the same kind follows before that, the first ends as aborted. Other requests, and stops and
  /// halts that are buffered, are queued; the cycle takes some of them at a time. If a later stop overtakes a queued
  /// motion, the motion ends as aborted.
  [[nodiscard]] std::uint64_t submit(std::size_t axis, const AxisRequest& request) noexcept;
  /// Progress of a request.
  [[nodiscard]] RequestReport report(std::uint64_t request) const noexcept { return table_.report(request); }
  /// Whether the cycle has taken a request that is not a stop. A motion that is still kWaiting then waits for its turn:
  /// the axis has accepted it.
  [[nodiscard]] bool taken(std::uint64_t request) const noexcept {
    return request <= taken_.load(std::memory_order_acquire);
  }
  /// State of an axis as of the last cycle; its values may come from two cycles.
  [[nodiscard]] AxisReport axis_report(std::size_t axis) const noexcept;
  /// Number of the gantry that an axis belongs to; none: it is a single axis.
  [[nodiscard]] std::optional<std::size_t> gantry_of(std::size_t axis) const noexcept;
  /// Settings of a gantry, in the order of add_gantry().
  [[nodiscard]] const GantrySettings& gantry_settings(std::size_t gantry) const noexcept {
    return gantries_[gantry]->settings();
  }
  /// State of a gantry (gantry_of()) as of the last cycle.
  [[nodiscard]] GantryReport gantry_report(std::size_t gantry) const noexcept { return gantries_[gantry]->report(); }
  /// Number of gantries.
  [[nodiscard]] std::size_t gantries() const noexcept { return gantries_.size(); }

  // Functions for the cycle thread. \rtsafe
  /// submit() for tasks of the cycle itself.
  std::uint64_t submit_in_cycle(std::size_t axis, const AxisRequest& request) noexcept;
  /// AxisCommand::kFollow, sent by the feed of the axis itself, without SetpointFeed::take(). Returns the number of the
  /// request.
  std::uint64_t follow_in_cycle(std::size_t axis) noexcept;
  /// Passes a request that the feed has taken on to the axis.
  void pass_on_in_cycle(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept;
  /// Reports the progress of a request that the feed has taken.
  void finish_in_cycle(std::uint64_t request, RequestReport report) noexcept { table_.set(request, report); }
  /// One axis, for tasks of the cycle.
  [[nodiscard]] const SingleAxis& axis(std::size_t number) const noexcept { return single_[number]; }
  void read_inputs(std::span<const std::byte> image, std::span<const bool> valid, std::span<const bool> operational,
                   std::span<const bool> fresh, std::chrono::nanoseconds took,
                   std::chrono::nanoseconds late = {}) noexcept override;
  void update(std::int64_t cycle, std::span<std::byte> image) noexcept override;
  AbsenceEffect resume(std::int64_t cycle, std::int64_t missed, std::span<std::byte> image) noexcept override;
  [[nodiscard]] std::chrono::nanoseconds path_late() const noexcept override { return {}; }
  [[nodiscard]] bool failed() const noexcept override;
  [[nodiscard]] std::span<const Axis> axes() const noexcept override { return axes_; }
  void fill(std::size_t axis, snapshot::AxisSample& sample) const noexcept override;
  [[nodiscard]] std::span<const trajectory::AxisSetpoint> setpoints() const noexcept override { return setpoints_; }

 private:
  /// AxisReport for other threads.
  struct Shared;
  /// The lane of stops.
  struct Stops;
  struct Feed {
    SetpointFeed* feed = nullptr;
    std::vector<std::size_t> axes{};
    std::vector<trajectory::AxisSetpoint> setpoints{};
    std::vector<char> joined{};
  };

  /// The feed that an axis may follow, and the number of the axis in it.
  struct FeedPlace {
    SetpointFeed* feed = nullptr;
    std::size_t place = 0;
  };

  void take(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept;
  [[nodiscard]] std::uint64_t submit_stop(std::size_t axis, const AxisRequest& request) noexcept;
  [[nodiscard]] std::size_t leader_of(std::size_t axis) const noexcept;
  void take_stops() noexcept;
  [[nodiscard]] bool overtaken(const NumberedRequest& request) noexcept;
  void hand_on(std::size_t axis, std::uint64_t id, const AxisRequest& request) noexcept;
  [[nodiscard]] std::size_t plan_waiting(std::size_t most) noexcept;
  void advance() noexcept;
  void advance(Feed& feed) noexcept;
  [[nodiscard]] static bool followed(const Feed& feed) noexcept;
  [[nodiscard]] bool all_reached(const Feed& feed) const noexcept;
  void publish(std::size_t axis) noexcept;

  std::vector<Axis> axes_;
  std::vector<SingleAxis> single_;
  double period_s_;
  std::chrono::nanoseconds took_{};
  std::vector<trajectory::AxisSetpoint> setpoints_;
  std::vector<char> led_;  ///< led by a feed in this cycle
  RequestTable table_;
  std::mutex submit_mutex_;  ///< serialises submitting threads, for the time of a copy; the cycle never locks it
  rt::SpscRing<NumberedRequest> requests_;
  std::atomic<std::uint64_t> taken_{0};  ///< number of the last request taken from requests_, which is in their order
  std::unique_ptr<Stops> stops_;
  std::unique_ptr<Shared[]> shared_;
  std::vector<Feed> feeds_;
  std::vector<FeedPlace> feed_of_;  ///< by axis number
  std::vector<std::unique_ptr<Gantry>> gantries_;
  std::vector<MasterSignal*> signals_;
  std::size_t turn_ = 0;  ///< first axis to check for due() in the next cycle
};

}  // namespace driveline::motion
