#pragma once

#include <cstdint>
#include <string_view>
#include <type_traits>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/motion/drive/probe_trigger.hpp"

namespace driveline::motion {

/// Commands to a single axis, named after the function blocks of PLCopen motion control part 1. The kRead... blocks are
/// missing, because reading needs no request.
enum class AxisCommand : std::uint8_t {
  kPower,             ///< MC_Power: `on`, to Operation enabled, or off; a moving axis comes to rest first
  kReset,             ///< MC_Reset: leaves ErrorStop, resetting the fault of the drive
  kHome,              ///< MC_Home: homing by the drive, as configured in it (6098h, 6099h, 609Ah, 607Ch)
  kStop,              ///< MC_Stop: comes to rest; other motion is refused until kReleaseStop
  kReleaseStop,       ///< withdraws the stop request (MC_Stop with Execute false)
  kHalt,              ///< MC_Halt: comes to rest; may be replaced by other motion
  kMoveAbsolute,      ///< MC_MoveAbsolute: to the position `target_si`
  kMoveRelative,      ///< MC_MoveRelative: by `target_si`, from the setpoint at its start
  kMoveAdditive,      ///< MC_MoveAdditive: by `target_si`, from the target of the previous motion
  kMoveSuperimposed,  ///< MC_MoveSuperimposed: by `target_si`, superimposed on the motion in progress
  kMoveVelocity,      ///< MC_MoveVelocity: at the velocity `target_si`, until stopped
  kFollow,            ///< follows the setpoints of a SetpointFeed; `target_si` is not used
  kTorque,            ///< MC_TorqueControl: with the torque `target_si`, no faster than `velocity_si`
  kSetPosition,       ///< MC_SetPosition: names the present setpoint `target_si`
  kSetOverride,       ///< MC_SetOverride: scales velocities by `target_si`, 0 to 2
  kSetMode,           ///< changes to the cyclic mode `mode`, bumpless
  kTouchProbe,    ///< MC_TouchProbe: records the position of the axis at `trigger`, within the window if one is given
  kAbortTrigger,  ///< MC_AbortTrigger: ends a touch probe request
  kHomeByProbe,   ///< homing by the master: up to `distance_si` until `trigger`, whose position is named `target_si`
  // Movements of the profile generator in the drive (all but kHaltSuperimposed).
  kDriveMoveAbsolute,  ///< to the position `target_si` (profile position mode)
  kDriveMoveRelative,  ///< by `target_si`, from the actual position
  kDriveMoveVelocity,  ///< at the velocity `target_si`, until stopped (profile velocity mode)
  kHaltSuperimposed,   ///< MC_HaltSuperimposed: the superimposed motion comes to rest, the motion below continues
  kDriveRun,           ///< at the velocity `target_si`, until stopped, along the ramp of the drive (velocity mode: U/f
                       ///< operation)
};

/// Whether the command brings an axis to rest or ends a stop: any client may send it. \rtsafe
[[nodiscard]] constexpr bool stops_or_releases(AxisCommand command) noexcept {
  return command == AxisCommand::kHalt || command == AxisCommand::kStop || command == AxisCommand::kReleaseStop;
}

/// Whether the command is a motion that ends at a target position. \rtsafe
[[nodiscard]] constexpr bool leads_to_position(AxisCommand command) noexcept {
  return command == AxisCommand::kMoveAbsolute || command == AxisCommand::kMoveRelative ||
         command == AxisCommand::kMoveAdditive || command == AxisCommand::kHomeByProbe;
}

/// Whether `target_si` of the request is a position or a distance. \rtsafe
[[nodiscard]] constexpr bool names_position(AxisCommand command) noexcept {
  return leads_to_position(command) || command == AxisCommand::kMoveSuperimposed ||
         command == AxisCommand::kSetPosition || command == AxisCommand::kDriveMoveAbsolute ||
         command == AxisCommand::kDriveMoveRelative;
}

/// Whether the drive itself generates the motion, at a velocity. \rtsafe
[[nodiscard]] constexpr bool runs_by_drive(AxisCommand command) noexcept {
  return command == AxisCommand::kDriveMoveVelocity || command == AxisCommand::kDriveRun;
}

/// Whether the drive itself generates the motion, to a position. \rtsafe
[[nodiscard]] constexpr bool positions_by_drive(AxisCommand command) noexcept {
  return command == AxisCommand::kDriveMoveAbsolute || command == AxisCommand::kDriveMoveRelative;
}

/// Mode of operation for a motion that the drive generates. \rtsafe
[[nodiscard]] constexpr cia402::Mode drive_mode(AxisCommand command) noexcept {
  if (positions_by_drive(command)) return cia402::Mode::kProfilePosition;
  return command == AxisCommand::kDriveRun ? cia402::Mode::kVelocity : cia402::Mode::kProfileVelocity;
}

/// How a motion follows the previous one (PLCopen part 1, 2.4.2 "Aborting versus buffered modes").
enum class BufferMode : std::uint8_t {
  kAborting,          ///< at once; replaces it and all waiting motions
  kBuffered,          ///< when the previous motion is done
  kBlendingLow,       ///< passes the end of the previous motion at the lower velocity of the two
  kBlendingPrevious,  ///< at the velocity of the previous motion
  kBlendingNext,      ///< at the velocity of this motion
  kBlendingHigh,      ///< at the higher velocity of the two
};

/// Whether the end of the previous motion is passed at a velocity. \rtsafe
[[nodiscard]] constexpr bool blends(BufferMode mode) noexcept {
  return mode != BufferMode::kAborting && mode != BufferMode::kBuffered;
}

/// Which of the equivalent positions of an axis with a modulo a motion goes to (PLCopen part 1, MC_Direction). Counted
/// from the position where the axis would come to rest if it braked now, so that it need not reverse.
enum class MoveDirection : std::uint8_t {
  kNone,      ///< the position itself, regardless of the number of turns
  kShortest,  ///< the nearest
  kPositive,  ///< the next one in positive direction
  kNegative,  ///< the next one in negative direction
};

/// A request to an axis. Copied bytewise through ring buffers. Members that end in `_si` are in SI units of the kind of
/// the axis: rad or m, per second where they are velocities, Nm or N.
struct AxisRequest {
  AxisCommand command = AxisCommand::kHalt;        ///< the command
  BufferMode buffer = BufferMode::kAborting;       ///< for motions; positioning by the drive: kAborting, kBuffered
  MoveDirection direction = MoveDirection::kNone;  ///< kMoveAbsolute of an axis with AxisConfig::modulo
  bool on = true;                                  ///< kPower
  std::int8_t mode = 8;  ///< kSetMode: 6060h, 8 to 10; 7 only from 8 and back, if the drive has it
  /// Position or distance in rad or m, velocity in rad/s or m/s, torque in Nm or force in N, or a factor, as `command`
  /// says.
  double target_si = 0.0;
  double velocity_si = 0.0;      ///< magnitude, rad/s or m/s; 0: the limit of the axis. Must not exceed it
  double acceleration_si = 0.0;  ///< rad/s^2 or m/s^2; 0: the limit. kTorque: Nm/s or N/s, 0: at once
  double deceleration_si = 0.0;  ///< likewise; 0: as `acceleration_si`
  double jerk_si = 0.0;          ///< rad/s^3 or m/s^3; 0: the limit of the axis
  ProbeTrigger trigger = ProbeTrigger::kFirstRising;  ///< kTouchProbe, kHomeByProbe
  double window_first_si = 0.0;                       ///< kTouchProbe: first end of the window of events, rad or m
  double window_last_si = 0.0;                        ///< other end of the window; equal ends: any position
  double distance_si = 0.0;                           ///< kHomeByProbe, signed by the direction, rad or m
};
static_assert(std::is_trivially_copyable_v<AxisRequest>);

/// Progress of a request, from which Done, Busy, Active, CommandAborted and Error of a function block follow.
enum class RequestPhase : std::uint8_t {
  kUnknown,  ///< no request has this number, or too many have followed since
  kWaiting,  ///< not taken yet, or buffered after another motion: Busy
  kActive,   ///< Busy and Active
  kReached,  ///< at its velocity or torque, and still in control: Busy, Active and InVelocity
  kDone,     ///< Done
  kAborted,  ///< CommandAborted: ended by another request, or by a failure of the axis
  kError,    ///< Error, with a reason; it moved nothing, or its motion has stopped
};

/// Whether a request in this phase has ended. \rtsafe
[[nodiscard]] constexpr bool is_over(RequestPhase phase) noexcept {
  return phase == RequestPhase::kDone || phase == RequestPhase::kAborted || phase == RequestPhase::kError;
}

/// Reason why a request was refused, or why an axis is in ErrorStop.
enum class AxisError : std::uint8_t {
  kNone,
  kNotEnabled,      ///< the axis is Disabled
  kErrorStop,       ///< the axis must be reset first
  kStopping,        ///< the stop request has not been withdrawn
  kNotFinite,       ///< a number is NaN or infinite, or a magnitude is negative
  kOverLimit,       ///< above a limit of the axis
  kOutsideRange,    ///< the target, or the path to it, is outside the software limits
  kBufferFull,      ///< too many motions are waiting
  kNothingToDo,     ///< no motion to superimpose on, or no stop to release
  kMode,            ///< the process data lack objects of the mode, or the command is not possible in the present mode
  kNoSuchMode,      ///< the drive does not have the mode (6502h)
  kNotAtRest,       ///< homing starts only at standstill, and nothing else starts during homing
  kModeTimeout,     ///< the drive has not changed its mode in time
  kEnableTimeout,   ///< the drive was not enabled in time
  kResetTimeout,    ///< the fault of the drive was not cleared in time
  kFault,           ///< the drive reports a fault
  kLost,            ///< the slave is missing or has left OP, or the drive has left Operation enabled on its own
  kMasterAway,      ///< the master missed too many periods
  kPosition,        ///< the actual position is implausible (PositionWatch)
  kHoming,          ///< homing by the drive failed
  kHomingTimeout,   ///< time-out of homing by the drive
  kTooFast,         ///< above the velocity limit under torque control
  kFollowingError,  ///< outside AxisConfig::following_error_window for too long
  kFollowing,       ///< the setpoints of the followed source are invalid
  kProbeObjects,    ///< the process data lack the touch probe (60B8h, 60B9h, and 60BAh to 60BDh of its edge)
  kProbe,           ///< the drive does not arm its touch probe
  kNoEdge,          ///< no event within the distance
  kNoTarget,        ///< the drive does not accept its target
  kDirection,       ///< a direction needs kMoveAbsolute of an axis with a modulo
  kVelocityCount,   ///< 6042h cannot hold the velocity, or its unit (604Ch) is not known
  kTargetTimeout,   ///< the drive has not reached its target in time
  kTooLong,         ///< the motion would last longer than trajectory::kLongestProfileSeconds
  kTooFar,          ///< a position beyond farthest_position(), or a target that 607Ah cannot hold
  kInGroup,         ///< the axis belongs to an enabled group (AxisGroups)
  // Errors of a gantry.
  kGantryFollower,  ///< the axis is a follower; requests go to its leader
  kGantry,          ///< the request would move the axes of the pair independently
  kGantryPartner,   ///< the other axis has failed, or the pair has separated
  kSkew,            ///< the skew of the pair exceeds, or exceeded, its limit
};

/// States of an axis (PLCopen part 1, figure "FB state diagram").
enum class PlcopenState : std::uint8_t {
  kDisabled,
  kStandstill,
  kHoming,
  kStopping,
  kDiscreteMotion,
  kContinuousMotion,
  kSynchronizedMotion,
  kErrorStop,
};

/// Name of a command as written in requests, such as "move_absolute". \rtsafe
[[nodiscard]] std::string_view to_text(AxisCommand command) noexcept;
/// Name of a state as in the standard, such as "DiscreteMotion". \rtsafe
[[nodiscard]] std::string_view to_text(PlcopenState state) noexcept;
/// Name of a phase, such as "active". \rtsafe
[[nodiscard]] std::string_view to_text(RequestPhase phase) noexcept;
/// The reason as the end of a sentence, such as "the axis is not enabled". \rtsafe
[[nodiscard]] std::string_view to_text(AxisError error) noexcept;
/// "none", "shortest", "positive" or "negative". \rtsafe
[[nodiscard]] std::string_view to_text(MoveDirection direction) noexcept;
/// Name of a buffer mode, such as "aborting", "buffered" or "blending_low". \rtsafe
[[nodiscard]] std::string_view to_text(BufferMode mode) noexcept;

}  // namespace driveline::motion
