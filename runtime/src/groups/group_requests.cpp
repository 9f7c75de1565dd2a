#include "driveline/runtime/groups/group_requests.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace driveline::runtime {
namespace {

using motion::GroupBuffer;
using motion::GroupCommand;
using motion::GroupError;
using motion::GroupMove;
using motion::GroupState;
using motion::RequestPhase;
using trajectory::PathMove;
using Verb = ClientGroupRequest::Verb;
using GroupWhy = GroupRefusal::Why;

/// Resolution of tool positions, m and rad: finer differences are rounding errors of the kinematics.
constexpr double kToolResolution = 1e-12;

/// Whether the request is a stop, which any client may send.
bool stops(Verb verb) noexcept {
  return verb == Verb::kHalt || verb == Verb::kStop || verb == Verb::kHold;
}

/// Whether the request takes the group away from the planned end of its moves.
bool ends_path(Verb verb) noexcept {
  return verb == Verb::kHalt || verb == Verb::kStop || verb == Verb::kDisable || verb == Verb::kReset;
}

GroupCommand command_of(Verb verb) noexcept {
  switch (verb) {
    case Verb::kEnable:
      return GroupCommand::kEnable;
    case Verb::kDisable:
      return GroupCommand::kDisable;
    case Verb::kReset:
      return GroupCommand::kReset;
    case Verb::kHold:
      return GroupCommand::kInterrupt;
    case Verb::kResume:
      return GroupCommand::kContinue;
    case Verb::kReverse:
      return GroupCommand::kReverse;
    case Verb::kForward:
      return GroupCommand::kForward;
    case Verb::kOverride:
      return GroupCommand::kSetOverride;
    case Verb::kStop:
      return GroupCommand::kStop;
    case Verb::kReleaseStop:
      return GroupCommand::kReleaseStop;
    case Verb::kMove:
    case Verb::kHalt:
      break;
  }
  return GroupCommand::kHalt;
}

GroupRefusal refuse(GroupWhy why) {
  GroupRefusal refusal;
  refusal.why = why;
  return refusal;
}

GroupRefusal bad_move(std::string reason) {
  auto refusal = refuse(GroupWhy::kBadMove);
  refusal.reason = std::move(reason);
  return refusal;
}

/// Returns the coordinates of the end of a move, one per axis.
std::vector<double> coordinates(const GroupMove& move, std::size_t axes) {
  if (axes > trajectory::kMaxGroupAxes) return move.target;
  const auto& place = end_of(move.path);
  return {place.begin(), place.begin() + static_cast<std::ptrdiff_t>(axes)};
}

void shift(trajectory::GroupVector& place, const std::vector<double>& by) {
  for (std::size_t i = 0; i < by.size(); ++i) place.at(i) += by[i];
}

/// Returns the move in absolute positions.
GroupMove absolute(GroupMove move, const std::vector<double>& from) {
  if (!move.relative) return move;
  move.relative = false;
  if (!move.target.empty()) {
    for (std::size_t i = 0; i < from.size() && i < move.target.size(); ++i) move.target[i] += from[i];
    return move;
  }
  shift(move.path.target, from);
  shift(move.path.center, from);
  shift(move.path.via, from);
  for (auto& point : move.path.points) shift(point, from);
  return move;
}

}  // namespace

/// Data of a group in addition to its own report.
struct GroupRequests::Group {
  /// Position at the end of the accepted requests; none: unknown while the group comes to rest.
  std::optional<std::vector<double>> place;
  bool halted = false;     ///< halted by this object since its last move
  std::uint64_t ends = 0;  ///< number of requests that have ended its path, or would have
  /// Caller that sends a path, and the number of its newest move; empty: none.
  std::string path_of{};
  std::uint64_t newest = 0;
};

/// Moves on trial, with all that their check needs, so that it runs without the lock.
struct GroupRequests::MoveCheck {
  MoveLimits limits;
  std::size_t axes = 0;
  std::optional<std::vector<double>> place;  ///< position at the end of the moves that were found right; none: unknown
  bool rests = false;                        ///< the group was at rest, without moves in progress
  std::uint64_t ends = 0;                    ///< value of Group::ends when the check started
};

GroupRequests::GroupRequests(const std::vector<AxisGroupConfig>& groups, AxisRequests& axes)
    : configs_(groups), axis_requests_(axes) {
  for (std::size_t i = 0; i < groups.size(); ++i) groups_.push_back(std::make_unique<Group>());
  if (!groups.empty()) axis_requests_.guard(this);
}

GroupRequests::~GroupRequests() {
  axis_requests_.guard(nullptr);
}

void GroupRequests::open(motion::AxisGroups& groups, motion::SingleAxes& axes,
                         std::vector<std::vector<GroupOutputLimits>> outputs) {
  const std::lock_guard guard(lock_);
  outputs_ = std::move(outputs);
  running_ = &groups;
  single_ = &axes;
}

void GroupRequests::close() {
  const std::lock_guard guard(lock_);
  running_ = nullptr;
  single_ = nullptr;
  pending_.clear();
  for (auto& group : groups_) ++group->ends;
}

std::vector<EventFacts> GroupRequests::take_events() {
  const std::lock_guard guard(lock_);
  return std::exchange(events_, {});
}

events::EventGroup GroupRequests::event_group(std::size_t group) const {
  const auto& config = configs_.at(group);
  events::EventGroup made{config.name, {}, {}};
  for (const auto axis : config.axes) made.axes.push_back(events::event_axis(axis_requests_.axes().at(axis)));
  made.coordinates = made.axes;
  if (!config.machine) return made;
  const auto coordinates = config.machine->coordinates(named_axes(made));
  for (std::size_t i = 0; i < config.machine->kinematics().coordinates().size(); ++i) {
    made.coordinates.at(i) = {};
    made.coordinates[i].name = coordinates[i].name;
    made.coordinates[i].unit = *coordinates[i].unit;
  }
  return made;
}

tl::expected<std::uint64_t, GroupRefusal> GroupRequests::submit(const AxisCaller& caller, std::size_t group,
                                                                const ClientGroupRequest& request) {
  if (group >= groups_.size()) return tl::unexpected(refuse(GroupWhy::kNotRunning));
  Guard checking(moves_lock_, std::defer_lock);
  if (request.verb == Verb::kMove) checking.lock();
  Guard guard(lock_);
  auto submitted = try_to_submit(caller, group, request, guard);
  events::GroupRequested asked{caller.name, event_group(group), request, {}};
  if (!submitted) asked.refusal = submitted.error();
  if (!caller.quiet) events_.emplace_back(std::move(asked));
  return submitted;
}

tl::expected<std::uint64_t, GroupRefusal> GroupRequests::try_to_submit(const AxisCaller& caller, std::size_t group,
                                                                       const ClientGroupRequest& request,
                                                                       Guard& guard) {
  if (auto moved = moved_together(group)) return tl::unexpected(std::move(*moved));
  if (running_ == nullptr) return tl::unexpected(refuse(GroupWhy::kNotRunning));
  constexpr double kMaxShare = 2.0;
  if (request.verb == Verb::kOverride && !(request.share >= 0.0 && request.share <= kMaxShare)) {
    auto refusal = refuse(GroupWhy::kShare);
    refusal.value = request.share;
    return tl::unexpected(std::move(refusal));
  }
  if (!stops(request.verb)) {
    if (auto refused = take(caller, group)) return tl::unexpected(std::move(*refused));
  }
  auto submitted = request.verb == Verb::kMove ? try_to_move(group, request, guard)
                                               : tl::expected<std::uint64_t, GroupRefusal>(running_->submit(
                                                     group, {command_of(request.verb), request.share}));
  if (!submitted) return submitted;
  if (*submitted == 0) return tl::unexpected(refuse(GroupWhy::kTooMany));
  if (ends_path(request.verb)) end_path(group);
  pending_.push_back({*submitted, *submitted, group, caller, request});
  return submitted;
}

/// Submits the move of a request. Releases the lock while the move is checked.
tl::expected<std::uint64_t, GroupRefusal> GroupRequests::try_to_move(std::size_t group,
                                                                     const ClientGroupRequest& request, Guard& guard) {
  find_place(group);
  auto move = request.move;
  const auto& place = groups_[group]->place;
  for (std::size_t i = 0; i < request.stays.size(); ++i) {
    if (!request.stays[i] || move.relative) continue;
    if (!place) return tl::unexpected(bad_move("its end position is not known while it comes to rest"));
    (move.target.empty() ? move.path.target.at(i) : move.target.at(i)) = (*place)[i];
  }
  auto& feed = move.path.feed;
  if (feed == 0.0 || feed > configs_[group].max_feed) feed = configs_[group].max_feed;
  auto check = begin_check(group);
  guard.unlock();
  auto wrong = check_move(check, move, move.buffer != GroupBuffer::kAborting);
  guard.lock();
  if (!wrong) wrong = end_check(group, check);
  if (wrong) return tl::unexpected(std::move(*wrong));
  groups_[group]->path_of.clear();
  return running_->move(group, move);
}

std::vector<double> GroupRequests::joints_of(std::size_t group) const {
  std::vector<double> joints;
  for (const auto axis : configs_[group].axes) joints.push_back(single_->axis_report(axis).setpoint);
  return joints;
}

/// Returns the position in the coordinates of the moves; empty: the machine has no solution.
std::vector<double> GroupRequests::place_of(std::size_t group) const {
  auto place = joints_of(group);
  const auto& machine = configs_[group].machine;
  if (!machine) return place;
  trajectory::GroupVector joints{};
  std::copy(place.begin(), place.end(), joints.begin());
  auto tool = joints;
  if (!machine->kinematics().forward(joints, tool)) return {};
  for (std::size_t i = 0; i < place.size(); ++i)
    place[i] = std::round(tool.at(i) / kToolResolution) * kToolResolution + 0.0;  // no -0
  return place;
}

/// At standstill without pending moves, sets the planned position to the actual setpoint of the axes, or of their tool.
void GroupRequests::find_place(std::size_t group) {
  if (!rests(group)) return;
  auto place = place_of(group);
  if (place.empty()) {
    groups_[group]->place.reset();
  } else {
    groups_[group]->place = std::move(place);
  }
}

bool GroupRequests::rests(std::size_t group) const {
  if (running_ == nullptr || running_->group_report(group).state == GroupState::kMoving) return false;
  return std::none_of(pending_.begin(), pending_.end(), [&](const Pending& pending) {
    const bool moves = !pending.request || pending.request->verb == Verb::kMove;
    return moves && pending.group == group && !running_->report(pending.last).over();
  });
}

MoveLimits GroupRequests::limits_of(std::size_t group) const {
  MoveLimits limits{event_group(group), {}, configs_[group].machine, {}};
  if (group < outputs_.size()) limits.outputs = outputs_[group];
  for (const auto axis : configs_[group].axes) {
    const auto& range = axis_requests_.axes()[axis].software_limits;
    const double offset = single_ == nullptr ? 0.0 : single_->axis_report(axis).position_offset;
    limits.ranges.push_back(range ? std::optional(trajectory::PositionRange{range->min + offset, range->max + offset})
                                  : std::nullopt);
  }
  return limits;
}

GroupRequests::MoveCheck GroupRequests::begin_check(std::size_t group) const {
  const auto& state = *groups_[group];
  return {limits_of(group), configs_[group].axes.size(), state.place, rests(group), state.ends};
}

/// Checks a move as far as its start is known. `goes_on`: it starts at the end of the preceding move. Called without
/// the lock: it may take as long as planning.
GroupRequests::Refused GroupRequests::check_move(MoveCheck& check, const GroupMove& move, bool goes_on) {
  const bool known = check.place && (goes_on || check.rests);
  if (auto wrong = check_outputs(check.limits, move.path)) return wrong;
  if (move.relative && !known) {
    check.place.reset();
    return std::nullopt;
  }
  const auto there = absolute(move, check.place.value_or(std::vector<double>(check.axes)));
  if (known && check.axes <= trajectory::kMaxGroupAxes) {
    trajectory::GroupVector from{};
    std::copy(check.place->begin(), check.place->end(), from.begin());
    if (auto wrong = check_group_move(check.limits, from, there.path)) return wrong;
  }
  check.place = coordinates(there, check.axes);
  return std::nullopt;
}

/// Takes the result of a check over, unless the group was stopped meanwhile: its moves would start elsewhere.
GroupRequests::Refused GroupRequests::end_check(std::size_t group, const MoveCheck& check) {
  auto& state = *groups_[group];
  if (running_ == nullptr) return refuse(GroupWhy::kNotRunning);
  if (state.ends != check.ends) return bad_move("the group was stopped before the move was accepted");
  state.place = check.place;
  state.halted = false;
  return std::nullopt;
}

tl::expected<TakenMoves, GroupRefusal> GroupRequests::add_moves(const AxisCaller& caller, std::size_t group,
                                                                std::span<const PathMove> moves, bool begins,
                                                                bool ends) {
  if (group >= groups_.size()) return tl::unexpected(refuse(GroupWhy::kNotRunning));
  const std::lock_guard checking(moves_lock_);
  Guard guard(lock_);
  auto taken = try_to_add(caller, group, moves, begins, ends, guard);
  if (begins || !taken) {
    events::GroupPathBegun begun{caller.name, event_group(group), {}};
    if (!taken) begun.refusal = taken.error();
    if (!caller.quiet) events_.emplace_back(std::move(begun));
  }
  return taken;
}

/// Releases the lock while the moves are checked.
tl::expected<TakenMoves, GroupRefusal> GroupRequests::try_to_add(const AxisCaller& caller, std::size_t group,
                                                                 std::span<const PathMove> moves, bool begins,
                                                                 bool ends, Guard& guard) {
  if (auto moved = moved_together(group)) return tl::unexpected(std::move(*moved));
  if (running_ == nullptr) return tl::unexpected(refuse(GroupWhy::kNotRunning));
  if (auto refused = take(caller, group)) return tl::unexpected(std::move(*refused));
  if (begins) {
    find_place(group);
  } else if (broken(group, caller)) {
    return tl::unexpected(bad_move("the path ended before this move; start a new path"));
  }
  const auto count = std::min(moves.size(), running_->room(group));
  std::vector<GroupMove> next;
  Refused wrong;
  auto check = begin_check(group);
  guard.unlock();
  for (const auto& path : moves.subspan(0, count)) {
    GroupMove move;
    move.path = path;
    if (path.feed > configs_[group].max_feed) move.path.feed = configs_[group].max_feed;
    const bool first = begins && next.empty();
    move.buffer = first ? GroupBuffer::kAborting : GroupBuffer::kBlending;
    move.continues = !(ends && next.size() + 1 == moves.size());
    wrong = check_move(check, move, !first);
    if (wrong) break;
    next.push_back(std::move(move));
  }
  guard.lock();
  if (auto ended = end_check(group, check)) return tl::unexpected(std::move(*ended));
  if (next.empty()) {
    if (wrong) return tl::unexpected(std::move(*wrong));
    return TakenMoves{};
  }
  const auto first = running_->move_path(group, next);
  if (first == 0) return tl::unexpected(refuse(GroupWhy::kTooMany));
  pending_.push_back({first, first + next.size() - 1, group, caller, {}});
  groups_[group]->path_of = caller.name;
  groups_[group]->newest = pending_.back().last;
  return TakenMoves{first, next.size()};
}

/// Whether the next moves would not start at the end of the path.
bool GroupRequests::broken(std::size_t group, const AxisCaller& caller) const {
  const auto& state = *groups_[group];
  const auto phase = running_->report(state.newest).phase;
  return state.path_of != caller.name || phase == RequestPhase::kAborted || phase == RequestPhase::kError;
}

GroupRequests::Refused GroupRequests::moved_together(std::size_t group) const {
  LeaseTerms terms;
  terms.take_over = true;
  for (const auto axis : configs_[group].axes) {
    const auto free = axis_requests_.authority().check(axis, terms);
    if (free) continue;
    auto refusal = refuse(GroupWhy::kMovedTogether);
    refusal.owner = free.error().owner;
    return refusal;
  }
  return std::nullopt;
}

GroupRequests::Refused GroupRequests::foreign(const AxisCaller& caller, std::size_t axis) const {
  const auto owner = axis_requests_.authority().owner_of(axis);
  if (owner.empty() || owner == caller.name || caller.take_over) return std::nullopt;
  auto refusal = refuse(GroupWhy::kOwned);
  refusal.owner = owner;
  refusal.axis = events::event_axis(axis_requests_.axes().at(axis));
  return refusal;
}

/// Takes the leases of all axes, or of none.
GroupRequests::Refused GroupRequests::take(const AxisCaller& caller, std::size_t group) {
  for (const auto axis : configs_[group].axes) {
    if (auto refused = foreign(caller, axis)) return refused;
  }
  auto terms = axis_requests_.terms_of(caller);
  terms.take_over = caller.take_over;
  for (const auto axis : configs_[group].axes) {
    if (axis_requests_.authority().take(axis, terms)) continue;
    auto refused = foreign(caller, axis);
    return refused ? std::move(refused) : refuse(GroupWhy::kOwned);
  }
  return std::nullopt;
}

GroupRefusal GroupRequests::of_group(std::size_t group, const motion::GroupRequestReport& report,
                                     std::uint64_t request) const {
  if (report.error == GroupError::kBadMove) return bad_move(running_->refusal(request));
  auto refusal = refuse(GroupWhy::kByGroup);
  refusal.error = report.error;
  // The following errors in the enumeration are errors of an axis, too.
  const bool of_axis = report.error >= GroupError::kAxisNotEnabled;
  if (of_axis && report.axis < axis_requests_.axes().size())
    refusal.axis = events::event_axis(axis_requests_.axes()[report.axis]);
  if (report.error != GroupError::kAxisFailed) return refusal;
  const auto state = running_->group_report(group);
  return state.failed_axis == report.axis ? refusal_of(state) : refusal;
}

GroupRefusal GroupRequests::refusal_of(const motion::GroupReport& report) const {
  auto refusal = refuse(GroupWhy::kByGroup);
  refusal.error = report.error;
  if (report.failed_axis < axis_requests_.axes().size())
    refusal.axis = events::event_axis(axis_requests_.axes()[report.failed_axis]);
  refusal.axis_error = report.axis_error;
  refusal.error_code = report.error_code;
  return refusal;
}

GroupProgress GroupRequests::progress(std::size_t group, std::uint64_t request) const {
  const std::lock_guard guard(lock_);
  return progress_of(group, request);
}

GroupProgress GroupRequests::progress_of(std::size_t group, std::uint64_t request) const {
  if (running_ == nullptr) {
    GroupProgress over;
    over.report.phase = RequestPhase::kAborted;
    over.refusal = refuse(GroupWhy::kNotRunning);
    return over;
  }
  // Before the report: moves that have been planned have their refusals there.
  const bool planned = running_->room(group) == motion::AxisGroups::kMaxMoves;
  GroupProgress progress{running_->report(request), {}, false};
  const auto phase = progress.report.phase;
  progress.accepted = phase == RequestPhase::kActive || phase == RequestPhase::kReached ||
                      phase == RequestPhase::kDone || (phase == RequestPhase::kWaiting && planned && is_move(request));
  if (progress.report.error != GroupError::kNone) progress.refusal = of_group(group, progress.report, request);
  return progress;
}

/// Whether the request is a move, or moves, that are still pending.
bool GroupRequests::is_move(std::uint64_t request) const {
  return std::any_of(pending_.begin(), pending_.end(), [request](const Pending& pending) {
    const bool moves = !pending.request || pending.request->verb == Verb::kMove;
    return moves && request >= pending.number && request <= pending.last;
  });
}

GroupStatus GroupRequests::status(std::size_t group) const {
  const std::lock_guard guard(lock_);
  const auto& axes = configs_.at(group).axes;
  GroupStatus status;
  status.limits = limits_of(group);
  status.owner = axis_requests_.authority().owner_of(axes.front());
  for (const auto axis : axes) {
    if (axis_requests_.authority().owner_of(axis) != status.owner) status.owner.clear();
  }
  if (running_ == nullptr) return status;
  status.report = running_->group_report(group);
  status.room = running_->room(group);
  status.setpoint = joints_of(group);
  status.place = place_of(group);
  return status;
}

void GroupRequests::leave(const std::string& caller, bool stop) {
  if (!stop) return;
  const std::lock_guard guard(lock_);
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    const auto& axes = configs_[group].axes;
    const auto his = [&](std::size_t axis) { return axis_requests_.authority().holds(axis, caller); };
    if (std::any_of(axes.begin(), axes.end(), his)) halt(group);
  }
}

void GroupRequests::release(const std::string& caller, std::size_t group) {
  for (const auto axis : configs_.at(group).axes) axis_requests_.authority().release(axis, caller);
}

/// Forgets the path of a group that is to come to rest, and lets moves that are being checked be refused.
void GroupRequests::end_path(std::size_t group) {
  auto& state = *groups_[group];
  ++state.ends;
  state.place.reset();
  state.path_of.clear();
}

void GroupRequests::halt(std::size_t group) {
  if (running_ == nullptr) return;
  ++groups_[group]->ends;
  if (groups_[group]->halted) return;
  if (running_->group_report(group).state != GroupState::kMoving && rests(group)) return;
  groups_[group]->halted = true;
  end_path(group);
  static_cast<void>(running_->submit(group, {GroupCommand::kHalt, 0.0}));
}

/// Called with the lock of the AxisRequests held.
bool GroupRequests::bring_to_rest(std::size_t axis) {
  const std::lock_guard guard(lock_);
  if (running_ == nullptr) return false;
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    const auto& axes = configs_[group].axes;
    if (std::find(axes.begin(), axes.end(), axis) == axes.end()) continue;
    const auto state = running_->group_report(group).state;
    if (state == GroupState::kDisabled || state == GroupState::kErrorStop) return false;
    halt(group);
    return true;
  }
  return false;
}

/// Called with the lock of the AxisRequests held.
bool GroupRequests::waits_for(const std::string& caller) {
  const std::lock_guard guard(lock_);
  return std::any_of(pending_.begin(), pending_.end(),
                     [&](const Pending& pending) { return pending.caller.name == caller; });
}

void GroupRequests::watch() {
  const std::lock_guard guard(lock_);
  if (running_ == nullptr) return;
  std::erase_if(pending_, [this](Pending& pending) {
    for (; pending.number <= pending.last; ++pending.number) {
      auto progress = progress_of(pending.group, pending.number);
      const auto phase = progress.report.phase;
      if (!progress.report.over() && phase != RequestPhase::kUnknown) return false;
      if (!progress.refusal) continue;
      if (!pending.caller.quiet) {
        events_.emplace_back(events::GroupRequestFailed{pending.caller.name, event_group(pending.group),
                                                        pending.request, std::move(*progress.refusal)});
      }
      // The moves after it have failed with it.
      return true;
    }
    return true;
  });
}

}  // namespace driveline::runtime
