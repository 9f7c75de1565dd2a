#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/ecat_master/group/group_request.hpp"
#include "driveline/runtime/event/axis_events.hpp"

namespace driveline::runtime {

/// What is asked of a group of axes, after the function blocks of PLCopen motion control part 4.
struct GroupRequest {
  /// The function block.
  enum class Verb : std::uint8_t {
    kEnable,       ///< MC_GroupEnable
    kDisable,      ///< MC_GroupDisable
    kReset,        ///< MC_GroupReset: of the group and of its axes
    kMove,         ///< MC_MoveLinearAbsolute, MC_MoveLinearRelative, MC_MoveCircularAbsolute
    kHold,         ///< MC_GroupInterrupt: to rest on the path
    kResume,       ///< MC_GroupContinue
    kReverse,      ///< backwards along the path, as far as it is known
    kForward,      ///< forwards again
    kOverride,     ///< MC_GroupSetOverride
    kHalt,         ///< MC_GroupHalt: to rest on the path, whose rest is dropped
    kStop,         ///< MC_GroupStop: the same, and no motion is taken until kReleaseStop
    kReleaseStop,  ///< the stop is withdrawn
  };
  Verb verb = Verb::kHalt;        ///< the function block
  ecat_master::GroupMove move{};  ///< kMove; a feed of 0: that of the group
  /// kMove: coordinates that stay where the group is to be at the end of what it was asked for before; empty: none.
  std::vector<bool> stays{};
  double share = 1.0;  ///< kOverride: 0 to 2
};

/// Why a request to a group was refused, or has failed. describe() makes the sentence.
struct GroupRefusal {
  /// The reason.
  enum class Why : std::uint8_t {
    kNotRunning,     ///< the line is not in operation, or has no such group
    kOwned,          ///< `owner` commands `axis`, one of the group's
    kMovedTogether,  ///< `owner` moves all axes as long as the line runs
    kShare,          ///< the override is not within 0 to 2
    kOutsideRange,   ///< the way leaves the software limits of `axis`: `value`, `lowest` to `highest` are possible
    kBadMove,        ///< `reason` tells what is wrong with it
    kTooMany,        ///< more requests than the cycle can take
    kByGroup,        ///< the group itself, with `error`
  };
  Why why = Why::kNotRunning;               ///< the reason
  std::string owner{};                      ///< kOwned, kMovedTogether
  std::optional<events::EventAxis> axis{};  ///< kOwned, kOutsideRange; kByGroup where the error is that of an axis
  std::string reason{};                     ///< kBadMove: a sentence without a full stop
  double value = 0.0;                       ///< kOutsideRange: rad or m; kShare
  double lowest = 0.0;                      ///< kOutsideRange: rad or m
  double highest = 0.0;                     ///< kOutsideRange: rad or m
  ecat_master::GroupError error{};          ///< kByGroup
  ecat_master::AxisError axis_error{};      ///< kByGroup: of `axis`, where it has failed
  std::uint16_t error_code = 0;             ///< kByGroup: of its drive (603Fh); 0: none
};

namespace events {

/// The group of an event.
struct EventGroup {
  std::string name;             ///< as configured
  std::vector<EventAxis> axes;  ///< in the order of the coordinates
  /// Of its moves: names and units. Those of a tool where the axes are the joints of a machine, else the axes again.
  std::vector<EventAxis> coordinates;
};

/// Somebody has asked something of a group of axes.
struct GroupRequested {
  std::string who;                        ///< "control socket (process 123, user 1000)"
  EventGroup group;                       ///< of which
  GroupRequest request;                   ///< what
  std::optional<GroupRefusal> refusal{};  ///< why it was refused; none: it was not
};
/// Somebody has begun to hand over a path for a group of axes, move by move.
struct GroupPathBegun {
  std::string who;                        ///< "control socket (process 123, user 1000)"
  EventGroup group;                       ///< of which
  std::optional<GroupRefusal> refusal{};  ///< why it was refused; none: it was not
};
/// A request, or a move, that had been taken has failed.
struct GroupRequestFailed {
  std::string who;                        ///< whose request
  EventGroup group;                       ///< of which
  std::optional<GroupRequest> request{};  ///< what was asked; none: a move of a path
  GroupRefusal refusal;                   ///< why
};
/// A group of axes is in GroupErrorStop: its axes come to rest on the path.
struct GroupFailed {
  EventGroup group;      ///< which
  GroupRefusal refusal;  ///< why
};
/// A group of axes has left GroupErrorStop.
struct GroupRestored {
  std::string group;  ///< its name
};

}  // namespace events

/// "enable" and the like, as it is written.
[[nodiscard]] std::string_view to_text(GroupRequest::Verb verb) noexcept;
/// A request in words: "move to x 10 mm, y 20 mm, feed 100 mm/s".
[[nodiscard]] std::string describe(const events::EventGroup& group, const GroupRequest& request);
/// The sentence of a refusal: "group plotter: axis y is commanded by stream".
[[nodiscard]] std::string describe(const events::EventGroup& group, const GroupRefusal& refusal);

}  // namespace driveline::runtime
