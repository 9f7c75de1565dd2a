#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <vector>

#include "driveline/ecat_master/single_axis/axis_request.hpp"
#include "driveline/trajectory/path_move.hpp"

namespace driveline::ecat_master {

/// What is asked of a group of axes besides motion, named after the function blocks of PLCopen motion control part 4.
enum class GroupCommand : std::uint8_t {
  kEnable,       ///< MC_GroupEnable: the group takes its axes, which must be in Standstill
  kDisable,      ///< MC_GroupDisable: gives them back; moving axes come to rest on the path first
  kReset,        ///< MC_GroupReset: leaves GroupErrorStop, resetting its axes, for GroupDisabled
  kStop,         ///< MC_GroupStop: to rest on the path; other motion is refused until kReleaseStop
  kReleaseStop,  ///< the stop request is withdrawn (MC_GroupStop with Execute false)
  kHalt,         ///< MC_GroupHalt: to rest on the path, which ends there
  kInterrupt,    ///< MC_GroupInterrupt: to rest on the path, which goes on with kContinue
  kContinue,     ///< MC_GroupContinue: on along the path
  kSetOverride,  ///< MC_GroupSetOverride: the feed times `value`, 0 to 2; 0 holds the axes on the path
  kReverse,      ///< back along the path, as far as it is still known
  kForward,      ///< forwards again
};

/// A request to a group. Copied as bytes through rings.
struct GroupRequest {
  GroupCommand command = GroupCommand::kHalt;  ///< what is asked
  double value = 0.0;                          ///< kSetOverride: the factor
};
static_assert(std::is_trivially_copyable_v<GroupRequest>);

/// How a move follows the one before it (PLCopen part 4, buffer and transition modes).
enum class GroupBuffer : std::uint8_t {
  kAborting,  ///< the axes come to rest on the path that they are on, which ends there; then this move
  kBuffered,  ///< when the one before it is done: the axes stop in between
  kBlending,  ///< without a stop: smoothly, or around the corner within the tolerance of the move before
};

/// A move of a group: MC_MoveLinearAbsolute and -Relative, MC_MoveCircularAbsolute and -Relative; several of them:
/// MC_MovePath. In rad or m, as the requests of the axes count (AxisCommand::kSetPosition included).
struct GroupMove {
  trajectory::PathMove path{};  ///< shape, target, feed along the path, tolerance of the corner behind it
  /// Instead of `path.target`, if it has values: one for each axis, also of more than trajectory::kMaxGroupAxes.
  std::vector<double> target{};
  bool relative = false;                        ///< all places are distances from where the move before ends
  GroupBuffer buffer = GroupBuffer::kAborting;  ///< how it follows the one before it
  /// Another one follows, which may be blended with it. If none comes in time the axes stop at its end all the same.
  bool continues = false;
};

/// States of a group (PLCopen part 4).
enum class GroupState : std::uint8_t {
  kDisabled,   ///< its axes take requests of their own
  kStandby,    ///< it has its axes, which stand
  kMoving,     ///< along a path, also while that is interrupted, held or followed backwards
  kStopping,   ///< until the stop is released
  kErrorStop,  ///< an axis has failed: the others come to rest on the path and are given back
};

/// Why a request was refused or aborted, or why a group is in GroupErrorStop.
enum class GroupError : std::uint8_t {
  kNone,
  kNotEnabled,      ///< the group is disabled
  kErrorStop,       ///< it must be reset first
  kStopping,        ///< the stop request has not been withdrawn
  kNotFinite,       ///< a number is NaN or infinite
  kOverLimit,       ///< the override is not within 0 to 2
  kNothingToDo,     ///< nothing is interrupted, stopped or under way that it could act on
  kBadMove,         ///< AxisGroups::refusal() has the sentence
  kAxisNotEnabled,  ///< an axis has no power
  kAxisMoves,       ///< an axis is not in Standstill
  kAxisErrorStop,   ///< an axis must be reset first
  kAxisRefused,     ///< an axis cannot be led now: while it changes its mode, for example
  kAxisFailed,      ///< an axis has failed: GroupReport has the facts
  kAxisAsked,       ///< a request to one of its axes has stopped the group
  kResetFailed,     ///< an axis could not be reset
};

/// How far a request to a group is, and why it failed.
struct GroupRequestReport {
  RequestPhase phase = RequestPhase::kUnknown;
  GroupError error = GroupError::kNone;  ///< of kError, and of kAborted by a failure
  std::size_t axis = 0;                  ///< number of the axis on the line, where the error is that of an axis

  /// Nothing more will happen to it. \rtsafe
  [[nodiscard]] constexpr bool over() const noexcept {
    return phase == RequestPhase::kDone || phase == RequestPhase::kAborted || phase == RequestPhase::kError;
  }
};

/// What a group does, as seen by other threads.
struct GroupReport {
  GroupState state = GroupState::kDisabled;
  GroupError error = GroupError::kNone;     ///< of GroupErrorStop
  std::size_t failed_axis = 0;              ///< number of the axis on the line that has failed first
  AxisError axis_error = AxisError::kNone;  ///< why
  std::uint16_t error_code = 0;             ///< 603Fh of its drive
  double override_factor = 1.0;             ///< GroupCommand::kSetOverride
  double speed = 0.0;                       ///< along the path, m/s or rad/s; negative backwards
  double length = 0.0;                      ///< along the path since its begin, m or rad
  std::uint64_t move = 0;                   ///< number of the request whose move is under way; 0: none is
  bool interrupted = false;                 ///< GroupCommand::kInterrupt
  bool backwards = false;                   ///< GroupCommand::kReverse
};

/// "enable" and the like, as requests are written. \rtsafe
[[nodiscard]] std::string_view to_text(GroupCommand command) noexcept;
/// "aborting", "buffered", "blending". \rtsafe
[[nodiscard]] std::string_view to_text(GroupBuffer buffer) noexcept;
/// "GroupStandby" and the like, as in the standard. \rtsafe
[[nodiscard]] std::string_view to_text(GroupState state) noexcept;
/// The reason as the end of a sentence: "the group is not enabled". \rtsafe
[[nodiscard]] std::string_view to_text(GroupError error) noexcept;

}  // namespace driveline::ecat_master
