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

/// How far the coupling of a slave to its master is.
enum class CouplingState : std::uint8_t {
  kIdle,        ///< has not begun
  kWaiting,     ///< the master has not come to the begin of the run-in
  kRunningIn,   ///< between the begin of the run-in and the place of synchronism
  kCatchingUp,  ///< on its way to where the law has the slave
  kInSync,      ///< where the law has the slave
  kReleased,    ///< goes on by itself, at a velocity or to rest
};

/// What a slave is brought to when it is coupled at once.
enum class CatchUp : std::uint8_t {
  kPosition,  ///< the position that the law has
  kVelocity,  ///< its velocity only: the law is moved to where the slave is by then (MC_GearIn)
};

/// What becomes of a slave of which its master asks more than its limits allow.
enum class OnLoss : std::uint8_t {
  kFollow,  ///< it follows with all that its limits allow, and catches up
  kStop,    ///< it comes to rest
};

/// What becomes of a slave that is released.
enum class Release : std::uint8_t {
  kKeepVelocity,  ///< on at the velocity of this instant
  kStop,          ///< to rest
};

/// Why a slave cannot be coupled.
enum class CouplingRefusal : std::uint8_t {
  kNone,
  kNotFinite,  ///< a state or a place is not finite
  kTooLate,    ///< the master has passed the begin of the run-in
  kNoWay,      ///< without a distance there is no run-in that never turns round
  kTooSteep,   ///< at the master's velocity the run-in needs more than the limits of the slave
};

/// The reason as the end of a sentence. \rtsafe
[[nodiscard]] std::string_view to_text(CouplingRefusal refusal) noexcept;

/// The setpoints of one axis that is coupled to a master by a law (a gear, a cam): catching up, in synchronism,
/// released.
///
/// * On its way to synchronism the slave is the law plus a deviation of limited jerk that goes to zero in the shortest
///   time: what the master may do is left free of the limits, and every step is held against them. So velocity,
///   acceleration and jerk of the slave stay within its limits whatever the master does on the way.
/// * In synchronism the slave is where the law has it, to the last bit, as long as its velocity and acceleration allow
/// it, as
///   told and as the change of its position; the jerk is then that of law and master.
/// * Where master and law ask for more the slave leaves the law within its limits (OnLoss). The jerk gives way there to
///   the limit of velocity, and to nothing else.
///
/// Master and slave are setpoints of the same instant in every call. A plain value; everything is \rtsafe: noexcept, no
/// allocation, bounded (at most one plan of a profile per step).
class Coupling {
 public:
  /// Limits that the master keeps, as far as they are known: left free of those of the slave. Infinite: not known.
  using MasterBounds = FollowLimits;

  /// Where a slave is to be in synchronism.
  struct SyncPlace {
    double master = 0.0;  ///< of the master, rad or m
    double distance =
        0.0;  ///< of the master from the begin of the run-in to there, >= 0; 0: the one with half the slope
  };

  Coupling() = default;
  /// Limits of the slave: velocity and acceleration positive and finite, the jerk positive. `period_s`: from step to
  /// step.
  Coupling(const FollowLimits& limits, double period_s) noexcept;

  /// What the master does at most; for what begins afterwards.
  void set_master_bounds(const MasterBounds& bounds) noexcept { bounds_ = bounds; }
  /// What happens when synchronism is lost.
  void set_on_loss(OnLoss on_loss) noexcept { on_loss_ = on_loss; }

  /// Couples the slave at once. Refused (it stays as it was): kNotFinite.
  [[nodiscard]] CouplingRefusal engage(const CouplingLaw& law, CatchUp catch_up, const AxisSetpoint& slave,
                                       const AxisSetpoint& master) noexcept;
  /// Couples the slave at a place of the master, which it comes to in the direction in which the place is now. Until
  /// the run-in begins the slave comes to rest and waits.
  [[nodiscard]] CouplingRefusal engage_at(const CouplingLaw& law, const SyncPlace& place, const AxisSetpoint& slave,
                                          const AxisSetpoint& master) noexcept;
  /// Ends the coupling.
  void release(Release how) noexcept;

  /// Moves the master, as the law sees it, to `offset` (rad or m) from where it is, by a motion within `limits`, which
  /// are those of the offset alone: the slave has to have as much left. False: the limits or the offset cannot be.
  [[nodiscard]] bool shift_phase_to(double offset, const ProfileLimits& limits) noexcept;

  /// The slave was moved beside what it was told: it is here, and finds back. \rtsafe
  void moved_to(const AxisSetpoint& slave) noexcept;

  /// The setpoint of the slave one period later, when the master is there.
  AxisSetpoint step(const AxisSetpoint& master) noexcept;

  /// \rtsafe
  [[nodiscard]] CouplingState state() const noexcept { return state_; }
  /// The slave was where the law has it in the last step. \rtsafe
  [[nodiscard]] bool in_sync() const noexcept { return state_ == CouplingState::kInSync; }
  /// How often it was in synchronism and was not any more, without being released. \rtsafe
  [[nodiscard]] std::uint32_t losses() const noexcept { return losses_; }
  /// The offset of the master as the law sees it: position in rad or m. \rtsafe
  [[nodiscard]] const AxisSetpoint& phase() const noexcept { return phase_; }
  /// The offset has arrived. \rtsafe
  [[nodiscard]] bool phase_reached() const noexcept { return !phase_profile_; }
  /// A released slave has come to rest, or to its velocity. \rtsafe
  [[nodiscard]] bool settled() const noexcept {
    return state_ == CouplingState::kReleased && exit_.finished(elapsed_s_);
  }
  /// The last setpoint. \rtsafe
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
  std::optional<Profile> deviation_{};  ///< of the slave from the law, to zero
  ProfileLimits deviation_limits_{};    ///< with which it was planned
  double elapsed_s_ = 0.0;              ///< of `deviation_`, or of `exit_`
  Profile exit_{};                      ///< once released
  AxisSetpoint phase_{};
  std::optional<Profile> phase_profile_{};
  double phase_s_ = 0.0;
  AxisSetpoint last_{};
  std::optional<double> step_velocity_{};  ///< from the last position but one to the last
  std::uint32_t losses_ = 0;
};

}  // namespace driveline::trajectory
