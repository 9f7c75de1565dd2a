#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/control/coast_watch.hpp"
#include "driveline/motion/control/following_error_watch.hpp"
#include "driveline/motion/control/lost_limit.hpp"
#include "driveline/motion/control/master_absence.hpp"
#include "driveline/motion/control/position_watch.hpp"
#include "driveline/motion/control/return_motion.hpp"
#include "driveline/motion/control/setpoint_supply.hpp"
#include "driveline/motion/single_axis/axis_request.hpp"
#include "driveline/motion/single_axis/motion_queue.hpp"
#include "driveline/motion/single_axis/request_table.hpp"
#include "driveline/motion/single_axis/setpoint_generator.hpp"
#include "driveline/motion/single_axis/torque_ramp.hpp"
#include "driveline/trajectory/rejoin.hpp"

namespace driveline::motion {

/// A single axis that is commanded on its own: the states of PLCopen part 1, its requests, and the resulting setpoints.
/// Used by the cycle thread only; everything except the constructor is \rtsafe.
///
/// Sequence in each cycle: read_inputs(), begin_cycle(), plan_in_turn() if due(), take() for each request, advance(),
/// write_outputs().
class SingleAxis {
 public:
  /// Settings of all axes.
  struct Settings {
    std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< cycle time
    /// Consecutive exchanges without valid process data after which the axis is stopped, and exchanges that the master
    /// itself may miss (LostLimit). For a drive that is exchanged in every cycle these are cycles.
    std::uint32_t bad_cycle_limit = 8;
    std::chrono::nanoseconds bad_time_limit{0};  ///< the same limit as a time (LostLimit::time); 0: none
    std::chrono::nanoseconds enable_timeout = std::chrono::seconds{2};   ///< until Operation enabled
    std::chrono::nanoseconds quick_stop_time = std::chrono::seconds{2};  ///< for the drive's own quick stop
    std::chrono::nanoseconds reset_timeout = std::chrono::seconds{2};    ///< until the fault is cleared
    std::chrono::nanoseconds mode_timeout = std::chrono::seconds{1};     ///< until 6061h shows the new mode
    std::chrono::nanoseconds homing_timeout = std::chrono::minutes{2};   ///< for homing by the drive
    std::chrono::nanoseconds target_timeout = std::chrono::minutes{2};   ///< for positioning by the drive
  };

  /// Motions that may wait for the one under way, and movements of the drive that may wait for the one it executes.
  static constexpr std::size_t kWaiting = 8;

  /// `axis` and `table` must outlive it.
  SingleAxis(Axis& axis, RequestTable& table, const Settings& settings);

  /// See MotionControl::read_inputs(); for this axis.
  void read_inputs(std::span<const std::byte> image, bool valid, bool operational, bool fresh,
                   std::chrono::nanoseconds late = {}) noexcept;
  /// Evaluates the effect of the last setpoint and the state of the drive. `took`: duration of the exchange.
  void begin_cycle(std::int64_t cycle, std::chrono::nanoseconds took) noexcept;
  /// Whether a motion needs planning; doing that in a later cycle only delays it.
  [[nodiscard]] bool due() const noexcept { return due_ != Due::kNone; }
  /// Plans the motion that is due().
  void plan_in_turn() noexcept;
  /// Takes a request in this cycle.
  void take(std::uint64_t id, const AxisRequest& request) noexcept;
  /// Gives the axis a feed to follow; `keeps_range`: the feed keeps the software limits. To be called before the cycle
  /// starts.
  void set_fed(bool keeps_range) noexcept {
    feed_.present = true;
    feed_.keeps_range = keeps_range;
  }
  /// Whether set_fed() was called.
  [[nodiscard]] bool fed() const noexcept { return feed_.present; }
  /// Makes the axis the follower of a gantry, whose leader provides its setpoints. To be called before the cycle
  /// starts.
  void set_in_formation() noexcept { feed_.present = feed_.in_formation = true; }
  /// Whether set_in_formation() was called.
  [[nodiscard]] bool in_formation() const noexcept { return feed_.in_formation; }
  /// Whether both inputs and position are from this cycle.
  [[nodiscard]] bool exchanged() const noexcept { return exchange_.good; }
  /// Whether the axis is at the setpoints that it follows, and no longer moving towards them.
  [[nodiscard]] bool led_exactly() const noexcept { return follows() && rejoin_.joined() && !beside_; }
  /// Whether the axis comes to rest by its setpoints, to be switched off then.
  [[nodiscard]] bool comes_to_rest() const noexcept { return power_.phase == Power::kResting; }
  /// Whether the setpoints no longer move the axis.
  [[nodiscard]] bool at_rest_without_setpoints() const noexcept { return !powered(); }
  /// Stops the axis by a ramp of the setpoint, because its drive may be in order, and then switches it off.
  void stop_by_ramp(AxisError error) noexcept;
  /// Stops the axis because the other axis of its gantry has failed: by a ramp, or by its drive.
  void stop_with_partner(bool by_ramp) noexcept;
  /// Sets the offset that is added to drive positions to get request positions, rad or m.
  void set_position_offset(double offset) noexcept { offset_ = offset; }
  /// Sets that offset as found by homing.
  void set_home(double offset) noexcept {
    offset_ = offset;
    homing_.homed = snapshot::AxisHomed::kYes;
  }
  /// Whether the axis follows its feed.
  [[nodiscard]] bool follows() const noexcept { return active_ && active_->request.command == AxisCommand::kFollow; }
  /// Whether the drive got the setpoint of its last exchange.
  [[nodiscard]] bool reached() const noexcept { return supply_.reached(); }
  /// Computes the setpoint of this cycle. `fed`: setpoint of the feed; null: the feed has ended, or is not followed.
  /// `waits`: the feed waits for other axes, and `fed` is still the previous setpoint (SetpointFeed::waits()).
  void advance(const trajectory::AxisSetpoint* fed, bool waits = false) noexcept;
  /// Writes control word, mode and targets of this cycle.
  void write_outputs(std::span<std::byte> image) noexcept;
  /// See MotionControl::resume().
  AbsenceEffect resume(std::int64_t cycle, std::int64_t missed) noexcept;

  /// PLCopen state as of the last cycle.
  [[nodiscard]] PlcopenState state() const noexcept { return state_; }
  /// Whether a request has homed the axis.
  [[nodiscard]] snapshot::AxisHomed homed() const noexcept { return homing_.homed; }
  /// Reason for ErrorStop.
  [[nodiscard]] AxisError error() const noexcept { return error_; }
  /// 603Fh at the time of the error.
  [[nodiscard]] std::uint16_t error_code() const noexcept { return error_code_; }
  /// The last setpoint, in drive positions.
  [[nodiscard]] const trajectory::AxisSetpoint& setpoint() const noexcept { return setpoint_; }
  /// Request position minus drive position (AxisCommand::kSetPosition), rad or m.
  [[nodiscard]] double position_offset() const noexcept { return offset_; }
  /// Position last recorded by AxisCommand::kTouchProbe, in request positions, and the number of its request; 0: never.
  struct Recorded {
    double position = 0.0;
    std::uint64_t request = 0;
  };
  /// The last recorded position. \rtsafe
  [[nodiscard]] const Recorded& recorded() const noexcept { return probe_.recorded; }
  /// Position of the superimposed motion on the followed setpoints (AxisCommand::kMoveSuperimposed), rad or m.
  [[nodiscard]] double on_top() const noexcept { return on_top_.motion.state().position; }
  /// Velocity factor set by AxisCommand::kSetOverride.
  [[nodiscard]] double override_factor() const noexcept { return override_; }
  /// Number of times that a motion has been planned, which is the time-consuming part of a cycle.
  [[nodiscard]] std::uint64_t planned() const noexcept { return planned_; }
  /// The axis in the process image.
  [[nodiscard]] const Axis& axis() const noexcept { return *axis_; }

 private:
  enum class Power : std::uint8_t {
    kOff,
    kEnabling,
    kOn,
    kResting,    ///< comes to rest, then is switched off
    kQuickStop,  ///< by the drive
    kDisabling,
  };
  /// Progress of a movement that the drive generates itself: homing, or by its profile generator.
  enum class ByDrive : std::uint8_t {
    kNone,
    kEntering,  ///< the drive changes to the mode of the movement
    kRunning,
    kAttained,     ///< home was found; the new zero must appear in the positions
    kInterrupted,  ///< the drive brakes
    kLeaving,      ///< the drive changes back to the previous mode
  };
  /// Progress of homing by the master.
  enum class Search : std::uint8_t {
    kNone,
    kArming,     ///< waiting until the touch probe is armed
    kSearching,  ///< moving until the event or the end of the distance
    kReturning,  ///< returning to the position of the event
  };
  /// Planning that is pending until the axis has its turn.
  enum class Due : std::uint8_t {
    kNone,
    kNext,     ///< the motion under way has ended, the next one starts
    kPassage,  ///< the end of the motion under way may be passed at a velocity
  };
  /// Source of the motion under kTorque.
  enum class Torque : std::uint8_t {
    kNone,
    kEntering,  ///< setpoints, until the drive is in CST
    kLed,       ///< the torque only
  };
  /// A motion that the axis has taken.
  struct Move {
    std::uint64_t id = 0;
    AxisRequest request{};
    double target = 0.0;  ///< target position, in drive positions; set at the start
  };
  /// How the end of a motion is passed.
  struct Passage {
    double velocity = 0.0;         ///< signed, rad/s or m/s
    trajectory::Profile way_on{};  ///< profile of the next motion from there, to rest
  };

  // Requests.
  [[nodiscard]] AxisError refusal(const AxisRequest& request) const noexcept;
  [[nodiscard]] AxisError refusal_by_state(const AxisRequest& request) const noexcept;
  [[nodiscard]] AxisError refusal_by_numbers(const AxisRequest& request) const noexcept;
  [[nodiscard]] AxisError refusal_by_drive(const AxisRequest& request) const noexcept;
  [[nodiscard]] AxisError refusal_of_torque(const AxisRequest& request) const noexcept;
  [[nodiscard]] AxisError refusal_of_profile(const AxisRequest& request) const noexcept;
  [[nodiscard]] AxisError refusal_of_probe(const AxisRequest& request) const noexcept;
  void take_power(std::uint64_t id, bool on) noexcept;
  void take_reset(std::uint64_t id) noexcept;
  void take_override(std::uint64_t id, double factor) noexcept;
  void take_mode(std::uint64_t id, std::int8_t mode) noexcept;
  void take_home(std::uint64_t id) noexcept;
  void take_profile(std::uint64_t id, const AxisRequest& request) noexcept;
  void take_probe(std::uint64_t id, const AxisRequest& request) noexcept;
  void take_abort_trigger(std::uint64_t id) noexcept;
  void take_search(std::uint64_t id, const AxisRequest& request) noexcept;
  void take_motion(std::uint64_t id, const AxisRequest& request) noexcept;
  void take_superimposed(std::uint64_t id, const AxisRequest& request) noexcept;
  void take_halt_superimposed(std::uint64_t id) noexcept;
  void finish(std::uint64_t& id, RequestPhase phase, AxisError error = AxisError::kNone) noexcept;
  void finish_move(RequestPhase phase, AxisError error = AxisError::kNone) noexcept;
  [[nodiscard]] bool keep_waiting(const Move& move) noexcept;
  void drop_waiting(AxisError error) noexcept;

  // Motions.
  void begin_move(const Move& move) noexcept;
  void go_from_here() noexcept;
  void rejoin_from(double position, double velocity) noexcept;
  void replan() noexcept;
  [[nodiscard]] bool plan_position(const Move& move) noexcept;
  [[nodiscard]] bool plan_rest() noexcept;
  [[nodiscard]] double passing_velocity(const Move& move, const Move& next) const noexcept;
  [[nodiscard]] std::optional<trajectory::Profile> way_behind(const Move& move, const Move& next,
                                                              double velocity) const noexcept;
  [[nodiscard]] std::optional<Passage> passage_of(const Move& move) const noexcept;
  [[nodiscard]] double velocity_of(const AxisRequest& request) const noexcept;
  [[nodiscard]] double jerk_of(const AxisRequest& request, const trajectory::AxisSetpoint& now) const noexcept;
  [[nodiscard]] double target_of(const AxisRequest& request, const trajectory::AxisSetpoint& from,
                                 double last_target) const noexcept;
  [[nodiscard]] double place_of(const AxisRequest& request, const trajectory::AxisSetpoint& from) const noexcept;
  [[nodiscard]] double resting_place(const AxisRequest& request, const trajectory::AxisSetpoint& from) const noexcept;
  [[nodiscard]] trajectory::ProfileLimits limits_of(const AxisRequest& request, double way,
                                                    const trajectory::AxisSetpoint& from) const noexcept;
  [[nodiscard]] trajectory::ProfileLimits full_limits() const noexcept;
  [[nodiscard]] trajectory::ProfileLimits rest_limits(const AxisRequest& request) const noexcept;
  [[nodiscard]] trajectory::ProfileLimits run_limits(const AxisRequest& request, double velocity) const noexcept;
  [[nodiscard]] std::optional<double> end_of_run(double velocity) const noexcept;
  [[nodiscard]] double most_acceleration() const noexcept;
  void advance_motion(const trajectory::AxisSetpoint* fed, bool waits) noexcept;
  void bridge() noexcept;
  [[nodiscard]] bool superimpose(std::uint64_t id, const AxisRequest& request) noexcept;
  [[nodiscard]] double velocity_on_top(const AxisRequest& request) const noexcept;
  void step_on_top(const trajectory::AxisSetpoint& target) noexcept;
  void settle_superimposed() noexcept;
  void drop_superimposed() noexcept;
  void step_to(const trajectory::AxisSetpoint& setpoint) noexcept;
  void step_back_to(const trajectory::AxisSetpoint& target) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint fed_to(const trajectory::AxisSetpoint& fed) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint with_on_top(const trajectory::AxisSetpoint& below) noexcept;
  void lead_to(const trajectory::AxisSetpoint& target) noexcept;
  void follow(const trajectory::AxisSetpoint* fed) noexcept;
  void arrive() noexcept;
  void rest() noexcept;
  void stay_at(double position) noexcept;
  [[nodiscard]] bool in_range(double position) const noexcept;
  [[nodiscard]] AxisError refusal_of_motion(const Move& move) const noexcept;
  [[nodiscard]] std::optional<trajectory::Profile> way_to(double target, const AxisRequest& request) const noexcept;
  [[nodiscard]] bool velocity_in_time(const AxisRequest& request) const noexcept;
  [[nodiscard]] bool can_continue() const noexcept;
  [[nodiscard]] bool leaves_range(const trajectory::AxisSetpoint& from) const noexcept;
  [[nodiscard]] bool plan_on() noexcept;
  [[nodiscard]] double velocity_below() noexcept;
  [[nodiscard]] bool run_at(double velocity) noexcept;
  void tell_velocity() noexcept;
  void tell_reached() noexcept;
  void end_motion() noexcept;
  void pass_end() noexcept;
  void begin_next() noexcept;

  // Movements that the drive generates itself.
  void enter(ByDrive phase) noexcept;
  void start_by_drive(std::uint64_t id, AxisCommand command, cia402::Mode mode) noexcept;
  void start_homing() noexcept;
  void interrupt_drive() noexcept;
  void advance_by_drive() noexcept;
  void judge_homing() noexcept;
  [[nodiscard]] bool homing_has_failed() noexcept;
  void watch_interruption() noexcept;
  [[nodiscard]] bool swings() noexcept;
  void take_new_zero() noexcept;
  void leave_drive_mode() noexcept;
  void end_by_drive() noexcept;
  void drop_by_drive(AxisError error) noexcept;
  [[nodiscard]] std::chrono::nanoseconds time_since(std::int64_t cycle) const noexcept;
  /// Whether the drive generates the motion and the setpoints of the master have no effect.
  [[nodiscard]] bool drive_moves() const noexcept {
    return drive_.phase > ByDrive::kEntering && drive_.phase < ByDrive::kLeaving;
  }
  [[nodiscard]] bool homes() const noexcept { return drive_.command == AxisCommand::kHome; }
  [[nodiscard]] double drive_target_of(const AxisRequest& request) const noexcept;
  [[nodiscard]] bool waits_for_drive(const AxisRequest& request) const noexcept;
  void begin_profile(const Move& move) noexcept;
  void give_to_drive(const Move& move) noexcept;
  void give_next_to_drive() noexcept;
  void begin_next_in_drive() noexcept;
  void start_profile() noexcept;
  void judge_profile() noexcept;
  void begin_torque() noexcept;
  void enter_torque() noexcept;
  void lead_by_torque() noexcept;
  void give_torque_up(AxisError error) noexcept;
  void advance_torque() noexcept;
  [[nodiscard]] double place_under_torque() const noexcept;
  void watch_torque() noexcept;
  void leave_torque() noexcept;
  void advance_probe() noexcept;
  void end_probe(RequestPhase phase, AxisError error) noexcept;
  void advance_search() noexcept;
  void end_search() noexcept;
  [[nodiscard]] bool arrive_in_search() noexcept;
  [[nodiscard]] bool name_home() noexcept;

  // States and power.
  void watch() noexcept;
  void watch_enabling() noexcept;
  void watch_power() noexcept;
  void judge_position(std::chrono::nanoseconds took) noexcept;
  void begin_powered() noexcept;
  void advance_reset() noexcept;
  [[nodiscard]] bool change_mode(cia402::Mode mode) noexcept;
  void advance_mode() noexcept;
  void judge_mode() noexcept;
  /// From interpolated position the drive can change to CSP only, unless it is the mode of its setpoints.
  [[nodiscard]] bool mode_may_change() const noexcept {
    const auto interpolated = cia402::Mode::kInterpolatedPosition;
    return !mode_change_.under_way && (axis_->mode() != interpolated || axis_->config().mode == interpolated);
  }
  [[nodiscard]] bool eases() const noexcept;
  void restore_mode() noexcept;
  void advance_powerless() noexcept;
  void fail(AxisError error) noexcept;
  void forget_place() noexcept;
  void stop_for_position() noexcept;
  void enter(Power power) noexcept;
  [[nodiscard]] bool powered() const noexcept { return power_.phase == Power::kOn || power_.phase == Power::kResting; }
  [[nodiscard]] bool off() const noexcept;
  [[nodiscard]] bool lost() const noexcept { return exchange_.bad >= exchange_.limit; }
  /// Whether the drive brakes on its own after `missed` periods. What it lacked before counts, too: behind an absence
  /// on CAN the setpoint of the period before has not taken effect either.
  [[nodiscard]] bool too_long(std::int64_t missed) const noexcept {
    return missed + supply_.lacking() > std::int64_t{exchange_.limit} * axis_->divider();
  }
  [[nodiscard]] bool exceeded(std::int64_t since, std::chrono::nanoseconds limit) const noexcept;
  [[nodiscard]] cia402::Goal goal() const noexcept;

  /// Power, and the request to change it.
  struct PowerChange {
    Power phase = Power::kOff;
    std::int64_t since = 0;            ///< cycle in which the phase began
    std::uint64_t request = 0;         ///< 0: none
    std::uint32_t cycles_at_rest = 0;  ///< in Power::kResting
  };
  /// Reset of a fault.
  struct FaultReset {
    std::int64_t since = 0;     ///< cycle of the request
    std::uint64_t request = 0;  ///< 0: none
  };
  /// Change from a cyclic mode to another.
  struct CyclicModeChange {
    std::int64_t since = 0;     ///< cycle of the request
    std::uint64_t request = 0;  ///< 0: none
    cia402::Mode before = cia402::Mode::kCyclicPosition;
    bool under_way = false;
    bool eased = false;                       ///< eases() in the last cycle
    std::optional<cia402::Mode> return_to{};  ///< mode to restore after homing or torque control
  };
  /// A movement that the drive generates.
  struct DriveMovement {
    ByDrive phase = ByDrive::kNone;
    AxisCommand command = AxisCommand::kHome;
    trajectory::AxisSetpoint target{};  ///< target of the drive's profile generator
    std::int64_t since = 0;             ///< cycle in which the phase, or the present target of several, started
    std::int64_t given_since = 0;       ///< cycle in which the last target was given
    std::int64_t still_since = 0;       ///< cycle since which the axis has been at rest
    double still_place = 0.0;           ///< position since still_since
    std::uint64_t request = 0;          ///< 0: none
    std::uint64_t next = 0;             ///< request of the target that the drive holds until the present one is reached
  };
  /// Torque control.
  struct TorqueControl {
    Torque phase = Torque::kNone;
    std::int64_t since = 0;  ///< cycle in which the change to CST started
    TorqueRamp ramp{};
  };
  /// Home position of the axis.
  struct Home {
    snapshot::AxisHomed homed = snapshot::AxisHomed::kUnknown;
    Search search = Search::kNone;
    double event = 0.0;  ///< position of the event found by the search, in drive positions
  };
  /// Touch probe.
  struct Probe {
    std::uint64_t request = 0;  ///< 0: none
    AxisRequest asked{};        ///< content of the request
    std::int64_t since = 0;     ///< cycle in which the probe was armed
    Recorded recorded{};
  };
  /// Exchanges with the drive.
  struct Exchanges {
    std::uint32_t limit;     ///< LostLimit::exchanges_of() of the axis
    std::uint32_t bad = 0;   ///< consecutive exchanges without valid process data
    bool good = false;       ///< the position is from this cycle
    bool last_good = false;  ///< the last exchange that was due succeeded
  };
  /// The feed that the axis may follow.
  struct Feed {
    bool present = false;       ///< set by set_fed()
    bool keeps_range = false;   ///< set by set_fed()
    bool in_formation = false;  ///< set by set_in_formation()
    std::uint32_t held_up = 0;  ///< consecutive cycles in which the feed has waited for other axes
  };
  /// Motion on top of a motion without an end.
  struct Superimposed {
    SetpointGenerator motion{};  ///< distance, starts at 0
    double velocity = 0.0;       ///< velocity that `motion` may have, rad/s or m/s
    bool active = false;
    bool holds_back = false;    ///< the velocity below is reduced for it
    std::uint64_t request = 0;  ///< 0: none
  };

  Axis* axis_;
  RequestTable* table_;
  Settings settings_;
  double period_s_;
  std::int64_t cycle_ = 0;
  PositionWatch watch_;
  FollowingErrorWatch following_watch_;
  CoastWatch coast_;
  SetpointSupply supply_;
  Exchanges exchange_;
  SetpointGenerator generator_{};
  Superimposed on_top_{};
  Feed feed_{};
  trajectory::Rejoin rejoin_{};                  ///< return to the setpoints of a feed, or of two motions
  std::optional<ReturnMotion> return_motion_{};  ///< return after a gap, once setpoints reach the drive again
  trajectory::AxisSetpoint setpoint_{};
  double step_velocity_ = 0.0;  ///< velocity of the last step to setpoint_, rad/s or m/s
  bool beside_ = false;         ///< after a gap, until setpoint_ is back at the generator
  PlcopenState state_ = PlcopenState::kDisabled;
  AxisError error_ = AxisError::kNone;
  std::uint16_t error_code_ = 0;
  PowerChange power_{};
  FaultReset reset_{};
  CyclicModeChange mode_change_{};
  DriveMovement drive_{};
  TorqueControl torque_{};
  Home homing_{};
  Probe probe_{};
  double offset_ = 0.0;
  double override_ = 1.0;
  double last_target_ = 0.0;
  std::optional<double> run_velocity_{};  ///< velocity of a kMoveVelocity towards the end of the range
  std::optional<Move> active_{};
  MotionQueue<Move, kWaiting> waiting_{};
  Due due_ = Due::kNone;
  std::uint64_t planned_ = 0;
};

}  // namespace driveline::motion
