#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <vector>

#include "driveline/motion/single_axis/axis_request.hpp"
#include "driveline/trajectory/path_move.hpp"

namespace driveline::motion {

/// Commands to a group of axes besides motion, named after the function blocks of PLCopen motion control part 4.
enum class GroupCommand : std::uint8_t {
  kEnable,       ///< MC_GroupEnable: the group takes over its axes, which must be in Standstill
  kDisable,      ///< MC_GroupDisable: releases the axes; moving axes first come to rest on the path
  kReset,        ///< MC_GroupReset: leaves GroupErrorStop for GroupDisabled and resets the axes
  kStop,         ///< MC_GroupStop: comes to rest on the path; other motion is refused until kReleaseStop
  kReleaseStop,  ///< withdraws the stop request (MC_GroupStop with Execute false)
  kHalt,         ///< MC_GroupHalt: comes to rest on the path, which ends there
  kInterrupt,    ///< MC_GroupInterrupt: comes to rest on the path, which kContinue resumes
  kContinue,     ///< MC_GroupContinue: resumes the path
  kSetOverride,  ///< MC_GroupSetOverride: scales the feed by `value`, 0 to 2; 0 holds the axes on the path
  kReverse,      ///< moves backwards along the path, as far as it is still stored
  kForward,      ///< moves forwards again
};

/// A request to a group. Copied bytewise through ring buffers.
struct GroupRequest {
  GroupCommand command = GroupCommand::kHalt;  ///< the command
  double value = 0.0;                          ///< kSetOverride: the factor
};
static_assert(std::is_trivially_copyable_v<GroupRequest>);

/// How a move follows the previous one (PLCopen part 4, buffer and transition modes).
enum class GroupBuffer : std::uint8_t {
  kAborting,  ///< the axes come to rest on the present path, which ends there; then this move starts
  kBuffered,  ///< when the previous move is done: the axes stop in between
  kBlending,  ///< without a stop: smoothly, or around the corner within the tolerance of the previous move
};

/// A move of a group: MC_MoveLinearAbsolute and -Relative, MC_MoveCircularAbsolute and -Relative; several moves form an
/// MC_MovePath. Positions are rad or m, as in requests to the axes (including AxisCommand::kSetPosition).
struct GroupMove {
  trajectory::PathMove path{};  ///< shape, target, feed along the path, tolerance of the corner at its end
  /// Replaces `path.target` if not empty: one value per axis, even for more than trajectory::kMaxGroupAxes axes.
  std::vector<double> target{};
  bool relative = false;                        ///< all positions are distances from the end of the previous move
  GroupBuffer buffer = GroupBuffer::kAborting;  ///< relation to the previous move
  /// Another move follows, which may be blended with this one. If it comes too late, the axes stop at the end of this
  /// move.
  bool continues = false;
};

/// States of a group (PLCopen part 4).
enum class GroupState : std::uint8_t {
  kDisabled,   ///< the axes take requests of their own
  kStandby,    ///< the group leads its axes, which are at standstill
  kMoving,     ///< on a path, including while it is interrupted, held or followed backwards
  kStopping,   ///< stopped, until the stop is released
  kErrorStop,  ///< an axis has failed: the others come to rest on the path and are released
};

/// Reason why a request was refused or aborted, or why a group is in GroupErrorStop.
enum class GroupError : std::uint8_t {
  kNone,
  kNotEnabled,      ///< the group is disabled
  kErrorStop,       ///< the group must be reset first
  kStopping,        ///< the stop request has not been withdrawn
  kNotFinite,       ///< a number is NaN or infinite
  kOverLimit,       ///< the override is not within 0 to 2
  kNothingToDo,     ///< nothing to resume, interrupt, release or reverse
  kBadMove,         ///< the move is not possible; AxisGroups::refusal() returns the reason
  kAxisNotEnabled,  ///< an axis has no power
  kAxisMoves,       ///< an axis is not in Standstill
  kAxisErrorStop,   ///< an axis must be reset first
  kAxisRefused,     ///< an axis cannot be commanded by the group now, for example while it changes its mode
  kAxisFailed,      ///< an axis has failed; details in GroupReport
  kAxisAsked,       ///< a request to an axis has stopped the group
  kResetFailed,     ///< an axis could not be reset
};

/// Progress of a request to a group, and why it failed.
struct GroupRequestReport {
  RequestPhase phase = RequestPhase::kUnknown;
  GroupError error = GroupError::kNone;  ///< reason for kError, and for kAborted after a failure
  std::size_t axis = 0;                  ///< number of the axis on the line, if the error concerns an axis

  /// Whether the request has ended. \rtsafe
  [[nodiscard]] constexpr bool over() const noexcept { return is_over(phase); }
};

/// State of a group as seen by other threads.
struct GroupReport {
  GroupState state = GroupState::kDisabled;
  GroupError error = GroupError::kNone;     ///< reason for GroupErrorStop
  std::size_t failed_axis = 0;              ///< number on the line of the axis that failed first
  AxisError axis_error = AxisError::kNone;  ///< error of that axis
  std::uint16_t error_code = 0;             ///< 603Fh of the drive of that axis
  double override_factor = 1.0;             ///< factor set by GroupCommand::kSetOverride
  double speed = 0.0;                       ///< along the path, m/s or rad/s; negative backwards
  double length = 0.0;                      ///< distance along the path since its start, m or rad
  std::uint64_t move = 0;                   ///< number of the request whose move is under way; 0: none
  bool interrupted = false;                 ///< GroupCommand::kInterrupt is in force
  bool backwards = false;                   ///< GroupCommand::kReverse is in force
};

/// Name of a command as written in requests, such as "enable". \rtsafe
[[nodiscard]] std::string_view to_text(GroupCommand command) noexcept;
/// "aborting", "buffered", "blending". \rtsafe
[[nodiscard]] std::string_view to_text(GroupBuffer buffer) noexcept;
/// Name of a state as in the standard, such as "GroupStandby". \rtsafe
[[nodiscard]] std::string_view to_text(GroupState state) noexcept;
/// The reason as the end of a sentence, such as "the group is not enabled". \rtsafe
[[nodiscard]] std::string_view to_text(GroupError error) noexcept;

}  // namespace driveline::motion
