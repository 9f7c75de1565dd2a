// Sentences of requests to axis groups.
#include <fmt/format.h>

#include <cmath>

#include "driveline/motion/cia402/error_code.hpp"
#include "event/event_sentence.hpp"

namespace driveline::runtime {
namespace {

using motion::GroupError;
using trajectory::PathMove;
using Verb = ClientGroupRequest::Verb;
using GroupWhy = GroupRefusal::Why;

std::string in_unit(const events::EventAxis& axis, double value, std::string_view per = "") {
  return fmt::format("{:.6g} {}{}", axis.unit.from_si(value), axis.unit.name, per);
}

/// Returns "x 10 mm, y 20 mm".
template <typename Values>
std::string place(const events::EventGroup& group, const Values& values, const std::vector<bool>& stays = {}) {
  std::string text;
  const auto& coordinates = group.coordinates;
  for (std::size_t i = 0; i < coordinates.size() && i < values.size(); ++i) {
    if (i < stays.size() && stays[i]) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", coordinates[i].name, in_unit(coordinates[i], values[i]));
  }
  return text.empty() ? "where it is" : text;
}

std::string move_text(const events::EventGroup& group, const ClientGroupRequest& request) {
  const auto& move = request.move;
  const auto& path = move.path;
  auto text = fmt::format(
      "{} {}", move.relative ? "by" : "to",
      move.target.empty() ? place(group, path.target, request.stays) : place(group, move.target, request.stays));
  if (path.kind == PathMove::Kind::kArcVia) text = fmt::format("on an arc {} via {}", text, place(group, path.via));
  if (path.kind == PathMove::Kind::kArc) {
    text =
        fmt::format("on an arc {} around {}{}", text, place(group, path.center), path.clockwise ? ", clockwise" : "");
  }
  if (group.coordinates.empty()) return text;
  const auto& first = group.coordinates.front();
  if (path.feed > 0.0 && std::isfinite(path.feed)) text += fmt::format(", feed {}", in_unit(first, path.feed, "/s"));
  if (path.tolerance > 0.0) text += fmt::format(", tolerance {}", in_unit(first, path.tolerance));
  if (move.buffer != motion::GroupBuffer::kAborting) text += fmt::format(", {}", to_text(move.buffer));
  return text;
}

/// Returns what to do about the error; empty if the reason is sufficient.
std::string remedy(const events::EventGroup& group, GroupError error) {
  switch (error) {
    case GroupError::kNotEnabled:
      return "; enable it first";
    case GroupError::kErrorStop:
    case GroupError::kAxisErrorStop:
      return fmt::format("; `driveline group {} reset` resets it", group.name);
    case GroupError::kStopping:
      return "; release-stop withdraws it";
    default:
      return "";
  }
}

std::string group_error_text(const events::EventGroup& group, const GroupRefusal& refusal) {
  auto text = std::string(to_text(refusal.error));
  if (refusal.axis) text = fmt::format("axis {}: {}", refusal.axis->name, text);
  if (refusal.axis_error != motion::AxisError::kNone) text += fmt::format(": {}", to_text(refusal.axis_error));
  if (refusal.error_code != 0) text += fmt::format(" ({})", motion::cia402::error_text(refusal.error_code));
  return text.append(remedy(group, refusal.error));
}

std::string reason_of(const events::EventGroup& group, const GroupRefusal& refusal) {
  const auto axis = refusal.axis.value_or(events::EventAxis{});
  switch (refusal.why) {
    case GroupWhy::kNotRunning:
      break;
    case GroupWhy::kOwned:
      return fmt::format("axis {} is commanded by {}", axis.name, refusal.owner);
    case GroupWhy::kMovedTogether:
      return fmt::format("its axes are moved by the {} of this run, together with the other axes", refusal.owner);
    case GroupWhy::kShare:
      return fmt::format("override {:.6g} is outside 0 to 2", refusal.value);
    case GroupWhy::kOutsideRange:
      return fmt::format("axis {}: position {} is outside {} to {} (min_position, max_position)", axis.name,
                         in_unit(axis, refusal.value), in_unit(axis, refusal.lowest), in_unit(axis, refusal.highest));
    case GroupWhy::kBadMove:
      return refusal.reason;
    case GroupWhy::kTooMany:
      return "too many requests: the request queue of the cycle is full";
    case GroupWhy::kByGroup:
      return group_error_text(group, refusal);
  }
  return "the line is not in operation";
}

}  // namespace

std::string_view to_text(Verb verb) noexcept {
  switch (verb) {
    case Verb::kEnable:
      return "enable";
    case Verb::kDisable:
      return "disable";
    case Verb::kReset:
      return "reset";
    case Verb::kMove:
      return "move";
    case Verb::kHold:
      return "hold";
    case Verb::kResume:
      return "resume";
    case Verb::kReverse:
      return "reverse";
    case Verb::kForward:
      return "forward";
    case Verb::kOverride:
      return "override";
    case Verb::kHalt:
      return "halt";
    case Verb::kStop:
      return "stop";
    case Verb::kReleaseStop:
      break;
  }
  return "release-stop";
}

std::string describe(const events::EventGroup& group, const ClientGroupRequest& request) {
  auto text = std::string(to_text(request.verb));
  if (request.verb == Verb::kMove) text += fmt::format(" {}", move_text(group, request));
  if (request.verb == Verb::kOverride) text += fmt::format(" {:.4g} %", 100.0 * request.share);
  return text;
}

std::string describe(const events::EventGroup& group, const GroupRefusal& refusal) {
  return fmt::format("group {}: {}", group.name, reason_of(group, refusal));
}

std::string EventSentence::operator()(const events::GroupRequested& facts) const {
  const auto asked = fmt::format("{}: group {}: {}", facts.who, facts.group.name, describe(facts.group, facts.request));
  return facts.refusal ? fmt::format("{}: refused: {}", asked, reason_of(facts.group, *facts.refusal)) : asked;
}

std::string EventSentence::operator()(const events::GroupPathBegun& facts) const {
  const auto asked = fmt::format("{}: group {}: path", facts.who, facts.group.name);
  return facts.refusal ? fmt::format("{}: refused: {}", asked, reason_of(facts.group, *facts.refusal)) : asked;
}

std::string EventSentence::operator()(const events::GroupRequestFailed& facts) const {
  const auto asked = facts.request ? describe(facts.group, *facts.request) : std::string("path");
  return fmt::format("{}: group {}: {}: failed: {}", facts.who, facts.group.name, asked,
                     reason_of(facts.group, facts.refusal));
}

std::string EventSentence::operator()(const events::GroupFailed& facts) const {
  return fmt::format("group {}: GroupErrorStop: {}; its axes come to rest on the path", facts.group.name,
                     reason_of(facts.group, facts.refusal));
}

std::string EventSentence::operator()(const events::GroupRestored& facts) const {
  return fmt::format("group {}: reset", facts.group);
}

}  // namespace driveline::runtime
