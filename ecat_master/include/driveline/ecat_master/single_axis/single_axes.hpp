#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "driveline/ecat_master/cyclic/motion_control.hpp"
#include "driveline/ecat_master/single_axis/axis_request.hpp"
#include "driveline/ecat_master/single_axis/gantry.hpp"
#include "driveline/ecat_master/single_axis/master_signal.hpp"
#include "driveline/ecat_master/single_axis/request_table.hpp"
#include "driveline/ecat_master/single_axis/setpoint_feed.hpp"
#include "driveline/ecat_master/single_axis/single_axis.hpp"
#include "driveline/rt/spsc_ring.hpp"

namespace driveline::ecat_master {

/// What an axis does, as seen by other threads. Positions as its requests count them (AxisCommand::kSetPosition).
struct AxisReport {
  PlcopenState state = PlcopenState::kDisabled;
  AxisError error = AxisError::kNone;  ///< of ErrorStop
  std::uint16_t error_code = 0;        ///< 603Fh when it failed
  std::int8_t mode = 0;                ///< 6061h
  double setpoint = 0.0;               ///< rad or m
  double position = 0.0;               ///< actual one
  double velocity = 0.0;               ///< actual one
  double torque = 0.0;                 ///< actual one, Nm or N
  double override_factor = 1.0;        ///< AxisCommand::kSetOverride
  double recorded_position = 0.0;      ///< by AxisCommand::kTouchProbe, as of that time; rad or m
  std::uint64_t recorded_request = 0;  ///< number of the request that has recorded it; 0: none
  double position_offset = 0.0;        ///< these positions are those of the drive plus this
};

/// Each axis of a line by itself, commanded by requests. One axis that fails does not stop the others.
///
/// The demand of a drive obeys the limits of its axis whatever is asked and whatever fails; positions advance only for
/// cycles in which the drive was given its setpoint.
class SingleAxes final : public MotionControl {
 public:
  /// Settings of all axes.
  using Settings = SingleAxis::Settings;

  /// @throws std::invalid_argument if a limit of an axis is not positive and finite, or its process data lack what its
  /// mode needs.
  SingleAxes(std::vector<Axis> axes, Settings settings);
  ~SingleAxes() override;
  SingleAxes(const SingleAxes&) = delete;
  SingleAxes& operator=(const SingleAxes&) = delete;

  /// Axes that may follow `feed`, by their numbers, in its order: what AxisCommand::kFollow means for them. Before the
  /// cycle starts; it must outlive this object.
  /// @throws std::invalid_argument if there is another number of axes than the feed has, no such axis, or one that has
  /// a feed.
  void add_feed(SetpointFeed& feed, std::vector<std::size_t> axes);
  /// Makes two axes one: requests of the leader move both, those of the follower are refused. Before the cycle starts.
  /// @throws std::invalid_argument for an axis that there is not, or that has a feed or is in a gantry already.
  void add_gantry(const GantrySettings& settings);
  /// A signal that is to be read in every cycle, before any feed is asked. Likewise.
  void add_signal(MasterSignal& signal) { signals_.push_back(&signal); }

  // Any thread.
  /// Hands a request to an axis; it is taken in the next cycle. The number to ask report() with; 0: there is no such
  /// axis, or more requests than the cycle can take; halts and stops have room of their own.
  [[nodiscard]] std::uint64_t submit(std::size_t axis, const AxisRequest& request) noexcept;
  /// How far a request is.
  [[nodiscard]] RequestReport report(std::uint64_t request) const noexcept { return table_.report(request); }
  /// State of an axis as of the last cycle; its figures may be of two cycles.
  [[nodiscard]] AxisReport axis_report(std::size_t axis) const noexcept;
  /// The gantry that an axis belongs to, by its number; none: it is a single axis.
  [[nodiscard]] std::optional<std::size_t> gantry_of(std::size_t axis) const noexcept;
  /// What add_gantry() was called with, in its order.
  [[nodiscard]] const GantrySettings& gantry_settings(std::size_t gantry) const noexcept {
    return gantries_[gantry]->settings();
  }
  /// Of gantry_of(); as of the last cycle.
  [[nodiscard]] GantryReport gantry_report(std::size_t gantry) const noexcept { return gantries_[gantry]->report(); }
  /// Gantries that there are.
  [[nodiscard]] std::size_t gantries() const noexcept { return gantries_.size(); }

  // The cycle's side. \rtsafe
  /// submit() for the cycle itself: tasks.
  std::uint64_t submit_in_cycle(std::size_t axis, const AxisRequest& request) noexcept;
  /// AxisCommand::kFollow, by the feed of the axis itself: SetpointFeed::take() is not asked. The number of the
  /// request.
  std::uint64_t follow_in_cycle(std::size_t axis) noexcept;
  /// Of a request that the feed has taken: for the axis after all.
  void pass_on_in_cycle(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept;
  /// Of a request that the feed has taken: how far it is.
  void finish_in_cycle(std::uint64_t request, RequestReport report) noexcept { table_.set(request, report); }
  /// One axis, for tasks of the cycle.
  [[nodiscard]] const SingleAxis& axis(std::size_t number) const noexcept { return single_[number]; }
  void read_inputs(std::span<const std::byte> image, std::span<const bool> valid, std::span<const bool> operational,
                   std::span<const bool> fresh, std::chrono::nanoseconds took) noexcept override;
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
  struct Feed {
    SetpointFeed* feed = nullptr;
    std::vector<std::size_t> axes{};
    std::vector<trajectory::AxisSetpoint> setpoints{};
    std::vector<char> joined{};
  };

  /// Which feed an axis may follow, and its number in it.
  struct FeedPlace {
    SetpointFeed* feed = nullptr;
    std::size_t place = 0;
  };

  void take(std::size_t axis, std::uint64_t request, const AxisRequest& asked) noexcept;
  void hand_on(std::size_t axis, std::uint64_t id, const AxisRequest& request) noexcept;
  [[nodiscard]] std::size_t plan_waiting(std::size_t most) noexcept;
  void advance() noexcept;
  void advance(Feed& feed) noexcept;
  [[nodiscard]] static bool followed(const Feed& feed) noexcept;
  void publish(std::size_t axis) noexcept;

  std::vector<Axis> axes_;
  std::vector<SingleAxis> single_;
  double period_s_;
  std::chrono::nanoseconds took_{};
  std::vector<trajectory::AxisSetpoint> setpoints_;
  std::vector<char> led_;  ///< by a feed, in this cycle
  RequestTable table_;
  std::mutex door_;  ///< of submitting threads; the cycle never takes it
  rt::SpscRing<NumberedRequest> requests_;
  std::unique_ptr<Shared[]> shared_;
  std::vector<Feed> feeds_;
  std::vector<FeedPlace> feed_of_;  ///< by axis
  std::vector<std::unique_ptr<Gantry>> gantries_;
  std::vector<MasterSignal*> signals_;
  std::size_t turn_ = 0;  ///< axis that is asked first whether it is due
};

}  // namespace driveline::ecat_master
