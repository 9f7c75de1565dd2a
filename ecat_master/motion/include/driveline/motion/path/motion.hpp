#pragma once

#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/control/coast_watch.hpp"
#include "driveline/motion/control/following_error_watch.hpp"
#include "driveline/motion/control/lost_limit.hpp"
#include "driveline/motion/control/master_absence.hpp"
#include "driveline/motion/control/motion_control.hpp"
#include "driveline/motion/control/position_watch.hpp"
#include "driveline/motion/control/return_motion.hpp"
#include "driveline/motion/control/setpoint_source.hpp"
#include "driveline/motion/control/setpoint_supply.hpp"
#include "driveline/rt/published_value.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path_extent.hpp"
#include "driveline/trajectory/start_ramp.hpp"
#include "driveline/trajectory/stop_profile.hpp"

namespace driveline::motion {

/// Phase of the coordinated motion of all axes.
enum class MotionPhase : std::uint8_t {
  kIdle,       ///< axes without power
  kEnabling,   ///< CiA 402 start-up of all axes
  kApproach,   ///< ramps from the actual positions to the first point of the path
  kFollowing,  ///< on the path
  kHolding,    ///< end of the setpoints: the axes hold the last setpoint
  kStopping,   ///< stop ramp to standstill on request
  kDisabling,  ///< CiA 402 shut-down of all axes
  kQuickStop,  ///< an axis or the communication failed: all drives stop by their own quick stop
  kWaiting,    ///< at rest on the path, or decelerating to it, until a missing axis is back
};

/// Display name of a phase, such as "following the path". \rtsafe
[[nodiscard]] std::string_view to_text(MotionPhase phase) noexcept;

/// Reason why the axes were stopped: by MotionPhase::kQuickStop, or by kStopping for an implausible position or a
/// following error.
struct MotionFailure {
  /// Kind of failure.
  enum class Cause : std::uint8_t {
    kNone,
    kAxisFault,
    kAxisLost,
    kCommunication,
    kEnableTimeout,
    kMasterAway,        ///< the master missed more exchanges than bad_cycle_limit
    kPositionLeap,      ///< the actual position jumped; details in `position`, as for the next two
    kPositionFrozen,    ///< the actual position is unchanged while the axis is commanded to move
    kPositionUnsteady,  ///< the actual position kept jumping, so the axis could not be enabled
    kSetpoint,          ///< the source gave a setpoint beyond the limits of the axis, or not a finite number
    kTooFast,           ///< the axis exceeded its velocity limit under a source that gives torques
    kFollowingError,    ///< beyond AxisConfig::following_error_window for too long; value in `following_error`
    kOutsideRange,      ///< its motion would leave AxisConfig::software_limits; position in `reaches`
  };
  Cause cause = Cause::kNone;     ///< kNone: there was no failure
  std::uint16_t axis = 0;         ///< number of the axis, as given to the constructor; the first if several failed
  std::uint16_t status_word = 0;  ///< 6041h at the failure
  std::uint16_t error_code = 0;   ///< 603Fh at the failure if mapped; else 0
  PositionFinding position{};     ///< details of an implausible actual position
  double following_error = 0.0;   ///< rad or m, for kFollowingError
  double reaches = 0.0;           ///< kOutsideRange: position that it would reach, rad or m
};

/// Participation of an axis in the motion. Other values than kPresent occur only for axes whose loss does not stop the
/// others (AxisConfig::on_loss).
enum class AxisPresence : std::uint8_t {
  kPresent,
  kMissing,    ///< no valid process data, or not in OP
  kEnabling,   ///< its process data are valid again: faults are reset, and it is enabled at its actual position
  kReturning,  ///< returns to the path within its limits
};

/// Reason why a source of setpoints was refused.
enum class SourceRefusal : std::uint8_t {
  kInMotion,   ///< sources change only while the axes are without power, or hold the end of the previous source
  kWrongAxes,  ///< the source moves another number of axes
};

/// Moves all axes together along a path, or by another source of setpoints: enables them, approaches the path, follows
/// it, and reacts to failures. An axis that fails stops all axes, because a path of several axes makes no sense without
/// one of them. If an axis is only missing (its slave is absent), its LossPolicy may say otherwise: when the axis is
/// back, it is enabled at its position and returned to the path within its limits. A drive that has a fault or switches
/// off stops all axes in any case.
///
/// The time along path, approach and stop counts only periods for which the drives got setpoints: at most one period
/// per cycle; none for missed periods, nor for cycles whose working counters do not confirm that the drives took their
/// outputs. A setpoint never jumps: drives without new setpoints continue at their last velocity for a short time and
/// then slow down (trajectory::Coast); the motion continues from the resulting position and returns the axes to the
/// path within their limits. Then the path stays late, or catches up (LatePolicy).
///
/// Commands come from any thread through atomics; everything else is for the cycle and is \rtsafe.
class Motion final : public MotionControl {
 public:
  /// Settings of the coordinated motion.
  struct Settings {
    std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< cycle time
    bool repeat = false;                                               ///< restart at the end of the path
    /// The path starts at the positions at which the axes are enabled: its first point is mapped to them.
    bool relative = false;
    /// Consecutive exchanges without valid process data of an axis after which all axes are stopped, and exchanges that
    /// the master itself may miss (LostLimit). For a drive that is exchanged in every cycle these are cycles.
    std::uint32_t bad_cycle_limit = 8;
    std::chrono::nanoseconds bad_time_limit{0};  ///< the same limit as a time (LostLimit::time); 0: none
    LatePolicy late = LatePolicy::kStay;         ///< behaviour of a path that is late
    /// The setpoints of a path lead it by the dead time of each axis (dead_time_cycles(), PathLeads). A source of the
    /// caller looks ahead on its own, as far as it can.
    bool compensate_dead_time = false;
    /// Time limit until all axes are in Operation enabled, also for an axis that has returned.
    std::chrono::nanoseconds enable_timeout = std::chrono::seconds{2};
    /// Time for the drives' own quick stop; then they are switched off.
    std::chrono::nanoseconds quick_stop_time = std::chrono::seconds{2};
  };

  /// `path` has one axis for each of `axes`, in the same order.
  /// @throws std::invalid_argument if their numbers differ, if a limit of an axis is not positive and finite (then
  /// approach and stop could not be planned), if its process data lack objects of its mode (missing_objects()), or if
  /// an axis in CST has no velocity gain.
  Motion(std::vector<Axis> axes, trajectory::Interpolator path, Settings settings);
  /// The same with another source than a path: as many axes as `axes`, in the same order. It must outlive the motion.
  Motion(std::vector<Axis> axes, SetpointSource& source, Settings settings);

  // Commands, for any thread.
  /// Enables all axes (resetting faults first) and follows the path. Ignored while they are not switched off. \rtsafe
  void request_start() noexcept { commands_.fetch_or(kStart, std::memory_order_release); }
  /// Brings all axes to standstill, then switches them off. A start that the cycle has not taken yet is withdrawn; a
  /// later start does not withdraw the stop. \rtsafe
  void request_stop() noexcept { commands_.store(kStop, std::memory_order_release); }
  /// Changes to another source, which must outlive the motion, at standstill and without stopping the cycle: at the
  /// next start, or at once if the axes hold the end of the previous source; then they approach its start. Error: the
  /// reason of the refusal; nothing has changed then. If another thread starts the motion at the same time, the start
  /// has priority and the source is not taken: check using_source().
  [[nodiscard]] tl::expected<void, SourceRefusal> use(SetpointSource& source) noexcept;
  /// The present source of setpoints, also before the start. \rtsafe
  [[nodiscard]] const SetpointSource& using_source() const noexcept {
    return *source_shared_.load(std::memory_order_acquire);
  }
  /// Phase as of the last cycle. \rtsafe
  [[nodiscard]] MotionPhase phase() const noexcept { return phase_shared_.load(std::memory_order_acquire); }
  /// Presence of an axis by its number, as of the last cycle. \rtsafe
  [[nodiscard]] AxisPresence presence(std::size_t axis) const noexcept {
    return presence_shared_[axis].load(std::memory_order_acquire);
  }
  /// The first failure since the last start, always complete; it precedes the phase that it causes. Not for the cycle.
  [[nodiscard]] MotionFailure failure() const noexcept { return failure_shared_.read(); }

  // Functions for the cycle. \rtsafe
  void read_inputs(std::span<const std::byte> image, std::span<const bool> valid, std::span<const bool> operational,
                   std::span<const bool> fresh = {}, std::chrono::nanoseconds took = {},
                   std::chrono::nanoseconds late = {}) noexcept override;
  void update(std::int64_t cycle, std::span<std::byte> image) noexcept override;
  AbsenceEffect resume(std::int64_t cycle, std::int64_t missed, std::span<std::byte> image) noexcept override;
  /// Delay of the path. Any thread.
  [[nodiscard]] std::chrono::nanoseconds path_late() const noexcept override {
    return std::chrono::nanoseconds{path_late_shared_.load(std::memory_order_relaxed)};
  }
  [[nodiscard]] bool failed() const noexcept override { return failure_.cause != MotionFailure::Cause::kNone; }

  [[nodiscard]] std::span<const Axis> axes() const noexcept override { return axes_; }
  [[nodiscard]] std::span<const trajectory::AxisSetpoint> setpoints() const noexcept override { return setpoints_; }

 private:
  /// Constructs a motion without a source.
  Motion(std::vector<Axis> axes, Settings settings);

  // Commands that the cycle has not taken yet. Both: the start came after the stop.
  static constexpr unsigned kStart = 1;
  static constexpr unsigned kStop = 2;

  /// State of an axis that is or was unavailable.
  struct Absence {
    AxisPresence presence = AxisPresence::kPresent;
    std::int64_t since = 0;  ///< cycle in which `presence` changed
    bool braking = false;    ///< the axis was commanded to stop, and comes to rest before it is enabled again
    ReturnMotion return_motion{};
  };
  /// Setpoints that have reached the drive of an axis, and its return to the path after a gap.
  struct Supply {
    SetpointSupply given{};
    bool beside_path = false;                     ///< after a gap, until the axis is back on the path
    std::optional<ReturnMotion> return_motion{};  ///< return to the path, once setpoints reach the drive again
  };

  /// Stop of an axis that coasted when it was enabled, before all axes are enabled.
  struct Arrest {
    std::optional<trajectory::StopProfile> stop{};  ///< from the setpoint at which the axis was enabled
    std::int64_t given = 0;                         ///< periods since then for which the drive got setpoints
  };

  /// Positions that a source may lead to, including the stopping distance.
  struct Reach {
    double lowest = -std::numeric_limits<double>::infinity();
    double highest = std::numeric_limits<double>::infinity();
    double way_per_square = 0.0;  ///< stopping distance per velocity squared
  };

  /// State of one axis.
  struct EachAxis {
    EachAxis(const Axis& axis, const Settings& settings);

    std::optional<trajectory::StartRamp> ramp{};
    std::optional<trajectory::StopProfile> stop{};
    std::optional<double> anchor{};  ///< offset of a relative path, set when the axis is enabled
    double before = 0.0;             ///< position of the target in the previous cycle, for the check of the source
    double most_velocity;            ///< velocity limit for a source
    Reach reach{};                   ///< positions that a source may lead to
    Supply supply;
    Absence absence{};
    Arrest arrest{};
    std::uint32_t lost_limit;         ///< LostLimit::exchanges_of()
    std::uint32_t bad_exchanges = 0;  ///< consecutive exchanges without valid process data
    PositionWatch position_watch;
    CoastWatch coast_watch;
    FollowingErrorWatch following_watch;
    bool exchanged = false;  ///< the position is from this cycle
    bool seen = false;       ///< the last exchange that was due succeeded
  };

  void enter(MotionPhase phase, std::int64_t cycle) noexcept;
  [[nodiscard]] double seconds(std::int64_t cycles) const noexcept;
  [[nodiscard]] double elapsed_s(std::int64_t cycle) const noexcept { return seconds(cycle - phase_start_); }
  /// The same, counted in periods for which setpoints were generated.
  [[nodiscard]] double given_s() const noexcept { return seconds(given_ - phase_given_); }
  void obey(std::int64_t cycle) noexcept;
  void start(std::int64_t cycle) noexcept;
  void stop(std::int64_t cycle) noexcept;
  void watch(std::int64_t cycle) noexcept;
  void set_failure(const MotionFailure& failure) noexcept;
  void fail(MotionFailure::Cause cause, std::size_t axis, std::int64_t cycle, double reaches = 0.0) noexcept;
  void abandon_enabling(std::int64_t cycle) noexcept;
  void judge_positions(std::int64_t cycle) noexcept;
  void forget_place(std::size_t axis) noexcept;
  void stop_for(const PositionFinding& finding, std::size_t axis, std::int64_t cycle) noexcept;
  [[nodiscard]] MotionFailure::Cause enable_failure(std::size_t axis) const noexcept;
  void watch_enabling(std::int64_t cycle) noexcept;
  void watch_axis(std::size_t axis, std::int64_t cycle) noexcept;
  void watch_following(std::size_t axis, std::int64_t cycle) noexcept;
  void watch_absence(std::size_t axis, std::int64_t cycle) noexcept;
  void set_presence(std::size_t axis, AxisPresence presence, std::int64_t cycle) noexcept;
  void aim() noexcept;
  [[nodiscard]] trajectory::AxisSetpoint aim_present(std::size_t axis) noexcept;
  void advance(std::int64_t cycle) noexcept;
  void advance_powerless(std::int64_t cycle) noexcept;
  void advance_stop(std::int64_t cycle) noexcept;
  void advance_enabling(std::int64_t cycle) noexcept;
  [[nodiscard]] bool arrest(std::size_t axis) noexcept;
  [[nodiscard]] bool arresting(std::size_t axis) const noexcept;
  void advance_path(std::int64_t cycle) noexcept;
  void supply_from_rest(std::size_t axis) noexcept;
  void note_supplies() noexcept;
  void bridge(std::size_t axis) noexcept;
  [[nodiscard]] bool path_must_wait_for_setpoints() const noexcept;
  void fall_behind(std::int64_t periods) noexcept;
  void tell_path_late() noexcept;
  void give_up(std::size_t axis, std::int64_t cycle) noexcept;
  void begin_path(std::int64_t cycle) noexcept;
  void begin_with(SetpointSource& source);
  [[nodiscard]] bool check_setpoints(std::int64_t cycle) noexcept;
  [[nodiscard]] bool plain_setpoints() const noexcept;
  [[nodiscard]] MotionFailure::Cause judge_setpoint(std::size_t axis) const noexcept;
  void set_ranges();
  [[nodiscard]] bool begins_in_range(std::size_t axis, std::int64_t cycle) noexcept;
  [[nodiscard]] double reach(std::size_t axis) const noexcept;
  [[nodiscard]] bool leaves_range(std::size_t axis) const noexcept;
  [[nodiscard]] bool in_ranges() const noexcept;
  void rewind_source() noexcept;
  void take_source(std::int64_t cycle) noexcept;
  void anchor(std::size_t axis) noexcept;
  /// Position of an axis that is not enabled.
  [[nodiscard]] double place_of(std::size_t axis) const noexcept { return each_[axis].position_watch.held(); }
  [[nodiscard]] bool must_wait() const noexcept;
  [[nodiscard]] bool powered() const noexcept { return powered_; }
  [[nodiscard]] bool unavailable(std::size_t axis) const noexcept;
  [[nodiscard]] bool lost(std::size_t axis) const noexcept {
    return each_[axis].bad_exchanges >= each_[axis].lost_limit;
  }
  [[nodiscard]] bool all_lost_with(std::size_t axis) const noexcept;
  [[nodiscard]] bool too_long(std::size_t axis, std::int64_t missed) const noexcept;
  [[nodiscard]] bool brakes(std::size_t axis, std::int64_t cycle) const noexcept;
  [[nodiscard]] bool tolerated(std::size_t axis) const noexcept {
    return axes_[axis].config().on_loss != LossPolicy::kStop;
  }
  [[nodiscard]] bool reset_due(std::size_t axis, std::int64_t cycle) const noexcept;
  void plan_approach() noexcept;
  void plan_stop() noexcept;
  [[nodiscard]] bool all_ready() const noexcept;
  [[nodiscard]] bool none_enabled() const noexcept;
  [[nodiscard]] bool all_available() const noexcept;
  [[nodiscard]] cia402::Goal goal(std::size_t axis) const noexcept;

  std::vector<Axis> axes_;
  std::vector<EachAxis> each_;            ///< by axis
  std::unique_ptr<SetpointSource> path_;  ///< null: the source belongs to the caller
  SetpointSource* source_;
  Settings settings_;
  std::vector<trajectory::AxisSetpoint> setpoints_;
  std::vector<trajectory::AxisSetpoint> source_start_;
  std::vector<trajectory::AxisSetpoint> targets_;  ///< setpoints of the source
  bool limited_ = false;                           ///< an axis has software limits
  std::vector<trajectory::PathExtent> extents_;    ///< extents of the path, if limited_
  std::int64_t path_begin_ = 0;                    ///< start of the path, in given periods
  std::int64_t given_ = 0;                         ///< periods since the start for which setpoints were generated
  std::int64_t phase_given_ = 0;                   ///< value of given_ when the phase started
  std::uint32_t held_up_ = 0;                      ///< consecutive periods in which the path waited for one axis
  std::unique_ptr<std::atomic<AxisPresence>[]> presence_shared_;
  std::chrono::nanoseconds exchange_took_{};
  MotionPhase phase_ = MotionPhase::kIdle;
  bool powered_ = false;  ///< the drives get setpoints in this phase
  std::int64_t phase_start_ = 0;
  MotionFailure failure_;  ///< changed by set_failure() only
  rt::PublishedValue<MotionFailure> failure_shared_;
  std::atomic<unsigned> commands_{0};
  std::atomic<MotionPhase> phase_shared_{MotionPhase::kIdle};
  std::atomic<std::int64_t> path_late_shared_{0};
  std::atomic<SetpointSource*> next_source_{nullptr};
  std::atomic<SetpointSource*> source_shared_{nullptr};
};

}  // namespace driveline::motion
