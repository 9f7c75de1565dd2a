#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/motion/group/group_request.hpp"
#include "driveline/runtime/event/axis_events.hpp"

namespace driveline::runtime {

/// Request to a group of axes, after the function blocks of PLCopen motion control part 4.
struct ClientGroupRequest {
  /// The function block.
  enum class Verb : std::uint8_t {
    kEnable,       ///< MC_GroupEnable
    kDisable,      ///< MC_GroupDisable
    kReset,        ///< MC_GroupReset: resets the group and its axes
    kMove,         ///< MC_MoveLinearAbsolute, MC_MoveLinearRelative, MC_MoveCircularAbsolute
    kHold,         ///< MC_GroupInterrupt: brings the axes to rest on the path
    kResume,       ///< MC_GroupContinue
    kReverse,      ///< moves backwards along the path, as far as it is stored
    kForward,      ///< moves forwards again
    kOverride,     ///< MC_GroupSetOverride
    kHalt,         ///< MC_GroupHalt: brings the axes to rest on the path and drops the remaining path
    kStop,         ///< MC_GroupStop: as kHalt; refuses motions until kReleaseStop
    kReleaseStop,  ///< releases the stop
  };
  Verb verb = Verb::kHalt;   ///< the function block
  motion::GroupMove move{};  ///< kMove; a feed of 0: default feed of the group
  /// kMove: coordinates that stay at their value at the end of the preceding requests; empty: none.
  std::vector<bool> stays{};
  double share = 1.0;  ///< kOverride: 0 to 2
};

/// Why a request to a group was refused or has failed. describe() makes the sentence.
struct GroupRefusal {
  /// The reason.
  enum class Why : std::uint8_t {
    kNotRunning,     ///< the line is not in operation, or has no such group
    kOwned,          ///< `owner` commands `axis`, an axis of the group
    kMovedTogether,  ///< `owner` moves all axes throughout the run
    kShare,          ///< the override is outside 0 to 2
    kOutsideRange,   ///< the path leaves the software limits of `axis`: `value` is not within `lowest` to `highest`
    kBadMove,        ///< the move is invalid, see `reason`
    kTooMany,        ///< more requests than the cycle can accept
    kByGroup,        ///< refused by the group itself, with `error`
  };
  Why why = Why::kNotRunning;  ///< the reason
  std::string owner{};         ///< set for kOwned, kMovedTogether
  /// Set for kOwned, kOutsideRange, and for kByGroup if the error is that of an axis.
  std::optional<events::EventAxis> axis{};
  std::string reason{};            ///< kBadMove: a sentence without a full stop
  double value = 0.0;              ///< kOutsideRange: rad or m; kShare
  double lowest = 0.0;             ///< kOutsideRange: rad or m
  double highest = 0.0;            ///< kOutsideRange: rad or m
  motion::GroupError error{};      ///< kByGroup
  motion::AxisError axis_error{};  ///< kByGroup: error of `axis`, if it has failed
  std::uint16_t error_code = 0;    ///< kByGroup: error code of its drive (603Fh); 0: none
};

namespace events {

/// The group of an event.
struct EventGroup {
  std::string name;             ///< name as configured
  std::vector<EventAxis> axes;  ///< in the order of the coordinates
  /// Names and units of the coordinates of its moves: those of a tool if the axes are the joints of a machine, else
  /// those of the axes.
  std::vector<EventAxis> coordinates;
};

/// A client has sent a request to a group of axes.
struct GroupRequested {
  std::string who;                        ///< "control socket (process 123, user 1000)"
  EventGroup group;                       ///< addressed group
  ClientGroupRequest request;             ///< the request
  std::optional<GroupRefusal> refusal{};  ///< reason of the refusal; none: not refused
};
/// A client has started to send a path for a group of axes, move by move.
struct GroupPathBegun {
  std::string who;                        ///< "control socket (process 123, user 1000)"
  EventGroup group;                       ///< addressed group
  std::optional<GroupRefusal> refusal{};  ///< reason of the refusal; none: not refused
};
/// An accepted request or move has failed.
struct GroupRequestFailed {
  std::string who;                              ///< name of the caller
  EventGroup group;                             ///< addressed group
  std::optional<ClientGroupRequest> request{};  ///< the request; none: a move of a path
  GroupRefusal refusal;                         ///< reason
};
/// A group of axes is in GroupErrorStop: its axes come to rest on the path.
struct GroupFailed {
  EventGroup group;      ///< failed group
  GroupRefusal refusal;  ///< reason
};
/// A group of axes has left GroupErrorStop.
struct GroupRestored {
  std::string group;  ///< name of the group
};

}  // namespace events

/// Returns the name of the request, "enable" and the like.
[[nodiscard]] std::string_view to_text(ClientGroupRequest::Verb verb) noexcept;
/// Returns a request in words: "move to x 10 mm, y 20 mm, feed 100 mm/s".
[[nodiscard]] std::string describe(const events::EventGroup& group, const ClientGroupRequest& request);
/// Returns the sentence of a refusal: "group plotter: axis y is commanded by stream".
[[nodiscard]] std::string describe(const events::EventGroup& group, const GroupRefusal& refusal);

}  // namespace driveline::runtime
