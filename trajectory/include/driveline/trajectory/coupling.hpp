#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "driveline/trajectory/coupling_law.hpp"
#include "driveline/trajectory/limited_axis.hpp"
#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Progress of the coupling of a slave to its master.
enum class CouplingState : std::uint8_t {
  kIdle,        ///< not started
  kWaiting,     ///< the master has not reached the start of the run-in
  kRunningIn,   ///< between the start of the run-in and the position of synchronism
  kCatchingUp,  ///< moving towards the position of the law
  kInSync,      ///< at the position of the law
  kReleased,    ///< independent of the master, at a constant velocity or stopping
};

/// Target of a slave that is coupled immediately.
enum class CatchUp : std::uint8_t {
  kPosition,  ///< the position that the law gives
  kVelocity,  ///< only the velocity of the law; the law is shifted to the slave's position at that time (MC_GearIn)
};

/// Reaction if the master demands more of a slave than the limits of the slave allow.
enum class OnLoss : std::uint8_t {
  kFollow,  ///< follow with all that the limits allow, then catch up
  kStop,    ///< come to rest
};

/// Behaviour of a released slave.
enum class Release : std::uint8_t {
  kKeepVelocity,  ///< continue at the present velocity
  kStop,          ///< come to rest
};

/// Reasons why a slave cannot be coupled.
enum class CouplingRefusal : std::uint8_t {
  kNone,
  kNotFinite,  ///< a state or a position is not finite
  kTooLate,    ///< the master has passed the start of the run-in
  kNoWay,      ///< a run-in without given distance would have to reverse
  kTooSteep,   ///< at the master's velocity the run-in would exceed the limits of the slave
};

/// The reason as the end of a sentence. \rtsafe
[[nodiscard]] std::string_view to_text(CouplingRefusal refusal) noexcept;

/// Setpoints of an axis that is coupled to a master by a law (a gear or a cam): catching up, in synchronism, released.
///
/// * While it catches up the slave follows the law plus a deviation of limited jerk that goes to zero in the shortest
///   time. The deviation leaves the part of the limits free that the master may use, and every step is checked against
///   the limits. So velocity, acceleration and jerk of the slave stay within its limits whatever the master does
///   meanwhile.
/// * In synchronism the slave is exactly at the position of the law, as long as its velocity and acceleration limits
///   allow it, both for the reported values and for the change of its position; its jerk is then that of law and
///   master.
/// * If master and law demand more, the slave leaves the law and stays within its limits (OnLoss). The jerk limit then
///   yields to the velocity limit, and to nothing else.
///
/// Master and slave are setpoints of the same instant in every call. A plain value; everything is \rtsafe: noexcept, no
/// allocation, bounded (at most one profile plan per step).
class Coupling {
 public:
  /// Limits that the master keeps, as far as they are known; they are reserved within the limits of the slave.
  /// Infinite: unknown.
  using MasterBounds = FollowLimits;

  /// Where a slave must be in synchronism.
  struct SyncPlace {
    double master = 0.0;    ///< position of the master at synchronism, rad or m
    double distance = 0.0;  ///< length of the run-in in master positions, >= 0; 0: mean slope is half the law's slope
  };

  Coupling() = default;
  /// `limits` of the slave: velocity and acceleration positive and finite, jerk positive. `period_s`: time between
  /// steps.
  Coupling(const FollowLimits& limits, double period_s) noexcept;

  /// Sets the limits that the master keeps; applies to couplings that start afterwards.
  void set_master_bounds(const MasterBounds& bounds) noexcept { bounds_ = bounds; }
  /// Sets the reaction to a loss of synchronism.
  void set_on_loss(OnLoss on_loss) noexcept { on_loss_ = on_loss; }

  /// Couples the slave immediately. Refused, without effect: kNotFinite.
  [[nodiscard]] CouplingRefusal engage(const CouplingLaw& law, CatchUp catch_up, const AxisSetpoint& slave,
                                       const AxisSetpoint& master) noexcept;
  /// Couples the slave at a position of the master, which the master reaches by moving towards it from its present
  /// position. Until the run-in starts the slave comes to rest and waits.
  [[nodiscard]] CouplingRefusal engage_at(const CouplingLaw& law, const SyncPlace& place, const AxisSetpoint& slave,
                                          const AxisSetpoint& master) noexcept;
  /// Ends the coupling.
  void release(Release how) noexcept;

  /// Moves the offset that the law adds to the master's position to `offset` (rad or m) by a motion within `limits`.
  /// These limits apply to the offset alone, so the slave needs that much reserve. Returns false if the limits or the
  /// offset are invalid.
  [[nodiscard]] bool shift_phase_to(double offset, const ProfileLimits& limits) noexcept;

  /// Reports that the slave was moved independently of its setpoints and is at `slave`; it then returns to the law.
  /// \rtsafe
  void moved_to(const AxisSetpoint& slave) noexcept;

  /// Returns the setpoint of the slave one period later, when the master is at `master`.
  AxisSetpoint step(const AxisSetpoint& master) noexcept;

  /// Progress of the coupling. \rtsafe
  [[nodiscard]] CouplingState state() const noexcept { return state_; }
  /// Whether the slave was at the position of the law in the last step. \rtsafe
  [[nodiscard]] bool in_sync() const noexcept { return state_ == CouplingState::kInSync; }
  /// Number of times that synchronism was lost without a release. \rtsafe
  [[nodiscard]] std::uint32_t losses() const noexcept { return losses_; }
  /// Present offset of the master's position for the law, rad or m. \rtsafe
  [[nodiscard]] const AxisSetpoint& phase() const noexcept { return phase_; }
  /// Whether the offset has reached its target. \rtsafe
  [[nodiscard]] bool phase_reached() const noexcept { return !phase_profile_; }
  /// Whether a released slave has come to rest, or reached its velocity. \rtsafe
  [[nodiscard]] bool settled() const noexcept {
    return state_ == CouplingState::kReleased && exit_.finished(elapsed_s_);
  }
  /// Last setpoint. \rtsafe
  [[nodiscard]] const AxisSetpoint& setpoint() const noexcept { return last_; }

 private:
  void begin(const CouplingLaw& law, CatchUp catch_up, const AxisSetpoint& slave) noexcept;
  [[nodiscard]] AxisSetpoint leading(const AxisSetpoint& master) const noexcept;
  void advance_phase() noexcept;
  [[nodiscard]] Cam::Value value_at(double master) noexcept;
  [[nodiscard]] AxisSetpoint deviated(const AxisSetpoint& wanted) noexcept;
  AxisSetpoint free_step() noexcept;
  AxisSetpoint limited_step(const AxisSetpoint& next, const AxisSetpoint& wanted, double slope) noexcept;
  [[nodiscard]] bool plan_deviation(const AxisSetpoint& wanted, double slope) noexcept;
  [[nodiscard]] bool could_be_faster(const AxisSetpoint& wanted, double slope) const noexcept;
  [[nodiscard]] ProfileLimits deviation_limits(const AxisSetpoint& wanted, double slope) const noexcept;
  [[nodiscard]] bool is_allowed(const AxisSetpoint& next) const noexcept;
  [[nodiscard]] bool keeps_jerk(const AxisSetpoint& next) const noexcept;
  [[nodiscard]] AxisSetpoint nearest(double acceleration) const noexcept;
  [[nodiscard]] double jerk_from(const AxisSetpoint& state) const noexcept;
  AxisSetpoint take(const AxisSetpoint& next) noexcept;

  double max_velocity_ = 1.0;
  double max_acceleration_ = 1.0;
  double max_jerk_ = 1.0;
  double period_s_ = 1.0;
  MasterBounds bounds_{};
  OnLoss on_loss_ = OnLoss::kFollow;
  CouplingState state_ = CouplingState::kIdle;
  CatchUp catch_up_ = CatchUp::kPosition;
  CouplingLaw law_{};
  std::optional<RunIn> run_in_{};
  std::optional<Profile> deviation_{};  ///< deviation of the slave from the law, going to zero
  ProfileLimits deviation_limits_{};    ///< limits with which `deviation_` was planned
  double elapsed_s_ = 0.0;              ///< time since the start of `deviation_` or `exit_`
  Profile exit_{};                      ///< motion after the release
  AxisSetpoint phase_{};
  std::optional<Profile> phase_profile_{};
  double phase_s_ = 0.0;
  AxisSetpoint last_{};
  std::optional<double> step_velocity_{};  ///< velocity of the last position step
  std::uint32_t losses_ = 0;
};

}  // namespace driveline::trajectory
