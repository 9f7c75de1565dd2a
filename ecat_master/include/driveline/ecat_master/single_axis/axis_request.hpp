#pragma once

#include <cstdint>
#include <string_view>
#include <type_traits>

#include "driveline/ecat_master/axis/probe_trigger.hpp"
#include "driveline/ecat_master/cia402/cia402.hpp"

namespace driveline::ecat_master {

/// What is asked of a single axis, named after the function blocks of PLCopen motion control part 1. All but
/// kRead... ones: reading needs no request.
enum class AxisCommand : std::uint8_t {
  kPower,             ///< MC_Power: `on`, Operation enabled, or off; a moving axis comes to rest first
  kReset,             ///< MC_Reset: leaves ErrorStop, resetting the fault of the drive
  kHome,              ///< MC_Home: homing by the drive, by what is set in it (6098h, 6099h, 609Ah, 607Ch)
  kStop,              ///< MC_Stop: to rest; other motion is refused until kReleaseStop
  kReleaseStop,       ///< the stop request is withdrawn (MC_Stop with Execute false)
  kHalt,              ///< MC_Halt: to rest; may be replaced by other motion
  kMoveAbsolute,      ///< MC_MoveAbsolute: to the position `target`
  kMoveRelative,      ///< MC_MoveRelative: by `target`, from the setpoint at its begin
  kMoveAdditive,      ///< MC_MoveAdditive: by `target`, from the target of the motion before
  kMoveSuperimposed,  ///< MC_MoveSuperimposed: by `target`, on top of the motion under way
  kMoveVelocity,      ///< MC_MoveVelocity: at the velocity `target`, for ever
  kFollow,            ///< the setpoints of a SetpointFeed; `target` is not used
  kTorque,            ///< MC_TorqueControl: with the torque `target`, no faster than `velocity`
  kSetPosition,       ///< MC_SetPosition: the present setpoint is called `target` from now on
  kSetOverride,       ///< MC_SetOverride: velocities times `target`, 0 to 2
  kSetMode,           ///< cyclic mode, `mode`, without a step
  kTouchProbe,        ///< MC_TouchProbe: records where the axis is at `trigger`, within the window if there is one
  kAbortTrigger,      ///< MC_AbortTrigger: nothing is recorded any more
  kHomeByProbe,       ///< homing by the master: as far as `distance` until `trigger`, whose place is called `target`
  // Movements of the profile generator in the drive.
  kDriveMoveAbsolute,  ///< to the position `target` (profile position mode)
  kDriveMoveRelative,  ///< by `target`, from where the axis is
  kDriveMoveVelocity,  ///< at the velocity `target`, for ever (profile velocity mode)
  kHaltSuperimposed,   ///< MC_HaltSuperimposed: what is on top of a motion comes to rest, the motion goes on
  kDriveRun,           ///< at the velocity `target`, for ever, by the ramp of the drive (velocity mode: U/f operation)
};

/// Brings an axis to rest, or ends a stop: everybody may ask for it, and there is always room for it. \rtsafe
[[nodiscard]] constexpr bool stops_or_releases(AxisCommand command) noexcept {
  return command == AxisCommand::kHalt || command == AxisCommand::kStop || command == AxisCommand::kReleaseStop;
}

/// A motion with a target, at which it ends. \rtsafe
[[nodiscard]] constexpr bool leads_to_position(AxisCommand command) noexcept {
  return command == AxisCommand::kMoveAbsolute || command == AxisCommand::kMoveRelative ||
         command == AxisCommand::kMoveAdditive || command == AxisCommand::kHomeByProbe;
}

/// Made by the drive itself, at a velocity. \rtsafe
[[nodiscard]] constexpr bool runs_by_drive(AxisCommand command) noexcept {
  return command == AxisCommand::kDriveMoveVelocity || command == AxisCommand::kDriveRun;
}

/// Made by the drive itself, to a position. \rtsafe
[[nodiscard]] constexpr bool positions_by_drive(AxisCommand command) noexcept {
  return command == AxisCommand::kDriveMoveAbsolute || command == AxisCommand::kDriveMoveRelative;
}

/// The mode of operation for that. \rtsafe
[[nodiscard]] constexpr cia402::Mode drive_mode(AxisCommand command) noexcept {
  if (positions_by_drive(command)) return cia402::Mode::kProfilePosition;
  return command == AxisCommand::kDriveRun ? cia402::Mode::kVelocity : cia402::Mode::kProfileVelocity;
}

/// How a motion follows the one before it (PLCopen part 1, 2.4.2 "Aborting versus buffered modes").
enum class BufferMode : std::uint8_t {
  kAborting,          ///< at once, replacing it and all that wait
  kBuffered,          ///< when it is done
  kBlendingLow,       ///< passing its end at the lower velocity of the two
  kBlendingPrevious,  ///< at the velocity of the motion before
  kBlendingNext,      ///< at its own velocity
  kBlendingHigh,      ///< at the higher velocity of the two
};

/// The end of the motion before is passed at a velocity. \rtsafe
[[nodiscard]] constexpr bool blends(BufferMode mode) noexcept {
  return mode != BufferMode::kAborting && mode != BufferMode::kBuffered;
}

/// An axis with a modulo passes a place of the same name in every turn: to which of them a motion to a position goes
/// (PLCopen part 1, MC_Direction). Counted from where it would come to rest if it braked now, so that it need not turn
/// round.
enum class MoveDirection : std::uint8_t {
  kNone,      ///< the position itself, however many turns it is away
  kShortest,  ///< the nearest
  kPositive,  ///< the next on the way up
  kNegative,  ///< the next on the way down
};

/// A request to an axis, in SI units: rad or m, Nm or N. Copied as bytes through rings.
struct AxisRequest {
  AxisCommand command = AxisCommand::kHalt;        ///< what is asked
  BufferMode buffer = BufferMode::kAborting;       ///< of motions; positions by the drive: kAborting, kBuffered
  MoveDirection direction = MoveDirection::kNone;  ///< kMoveAbsolute of an axis with AxisConfig::modulo
  bool on = true;                                  ///< kPower
  std::int8_t mode = 8;       ///< kSetMode: 6060h, 8 to 10; 7 from 8, and back, where the drive has it
  double target = 0.0;        ///< position, distance, velocity, torque or factor
  double velocity = 0.0;      ///< magnitude, rad/s or m/s; 0: the limit of the axis. Others than 0 must not be above it
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2; 0: the limit. kTorque: torque per second, 0: at once
  double deceleration = 0.0;  ///< likewise; 0: as `acceleration`
  double jerk = 0.0;          ///< rad/s^3 or m/s^3; 0: the limit of the axis
  ProbeTrigger trigger = ProbeTrigger::kFirstRising;  ///< kTouchProbe, kHomeByProbe
  double window_first = 0.0;                          ///< kTouchProbe: positions at which an event counts
  double window_last = 0.0;                           ///< the other end; the same: any position
  double distance = 0.0;                              ///< kHomeByProbe, with the sign of the direction
};
static_assert(std::is_trivially_copyable_v<AxisRequest>);

/// How far a request is. Done, Busy, Active, CommandAborted and Error of a function block follow from it.
enum class RequestPhase : std::uint8_t {
  kUnknown,  ///< there was none of this number, or too many since
  kWaiting,  ///< not taken yet, or buffered behind another motion: Busy
  kActive,   ///< Busy and Active
  kReached,  ///< in velocity or in torque, and still in control: Busy, Active and InVelocity
  kDone,     ///< Done
  kAborted,  ///< CommandAborted: another request, or a failure of the axis, has ended it
  kError,    ///< Error, with a reason; nothing was moved by it, or what it moved has stopped
};

/// Why a request was refused, or why an axis is in ErrorStop.
enum class AxisError : std::uint8_t {
  kNone,
  kNotEnabled,      ///< the axis is Disabled
  kErrorStop,       ///< it must be reset first
  kStopping,        ///< the stop request has not been withdrawn
  kNotFinite,       ///< a number is NaN or infinite, or a magnitude is negative
  kOverLimit,       ///< above a limit of the axis
  kOutsideRange,    ///< the target, or the way to it, leaves the software limits
  kBufferFull,      ///< too many motions wait
  kNothingToDo,     ///< superimposed on nothing, released without a stop
  kMode,            ///< the process data lack what the mode needs, or the command cannot be done in the present mode
  kNoSuchMode,      ///< the drive does not have the mode (6502h)
  kNotAtRest,       ///< homing begins at a standstill, and nothing else begins while it lasts
  kModeTimeout,     ///< the drive has not changed its mode in time
  kEnableTimeout,   ///< the drive was not enabled in time
  kResetTimeout,    ///< the fault of the drive stayed
  kFault,           ///< the drive reports a fault
  kLost,            ///< the slave is not there, has left OP, or the drive has left Operation enabled by itself
  kMasterAway,      ///< the master missed too many periods
  kPosition,        ///< the actual position cannot be true (PositionWatch)
  kHoming,          ///< the drive could not home
  kHomingTimeout,   ///< the drive has not homed in time
  kTooFast,         ///< faster than its limit under a torque
  kFollowingError,  ///< beyond AxisConfig::following_error_window for too long
  kFollowing,       ///< the setpoints of the source that it follows cannot be
  kProbeObjects,    ///< the process data lack the touch probe (60B8h, 60B9h, and 60BAh to 60BDh of its edge)
  kProbe,           ///< the drive does not switch its touch probe on
  kNoEdge,          ///< there was no event within the distance
  kNoTarget,        ///< the drive has not taken its target
  kDirection,       ///< a direction is for positions of an axis that has a modulo
  kVelocityCount,   ///< 6042h cannot hold the velocity, or what it counts in (604Ch) is not known
  kTargetTimeout,   ///< the drive has not reached its target in time
  kInGroup,         ///< the axis belongs to a group that is enabled (AxisGroups)
  // Of a gantry.
  kGantryFollower,  ///< its leader is commanded
  kGantry,          ///< what would lead each axis by itself
  kGantryPartner,   ///< the other axis has failed, or the pair has parted
  kSkew,            ///< the pair is, or was, out of skew
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

/// "move_absolute" and the like, as requests are written. \rtsafe
[[nodiscard]] std::string_view to_text(AxisCommand command) noexcept;
/// "DiscreteMotion" and the like, as in the standard. \rtsafe
[[nodiscard]] std::string_view to_text(PlcopenState state) noexcept;
/// "active" and the like. \rtsafe
[[nodiscard]] std::string_view to_text(RequestPhase phase) noexcept;
/// The reason as the end of a sentence: "the axis is disabled". \rtsafe
[[nodiscard]] std::string_view to_text(AxisError error) noexcept;
/// "shortest", "positive", "negative"; "none". \rtsafe
[[nodiscard]] std::string_view to_text(MoveDirection direction) noexcept;
/// "aborting", "buffered", "blending_low" and so on. \rtsafe
[[nodiscard]] std::string_view to_text(BufferMode mode) noexcept;

}  // namespace driveline::ecat_master
