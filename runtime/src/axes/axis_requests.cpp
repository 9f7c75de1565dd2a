#include "driveline/runtime/axes/axis_requests.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "axes/line_couplings.hpp"
#include "axes/request_check.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::AxisError;
using motion::AxisRequest;
using motion::PlcopenState;
using motion::RequestPhase;
using Why = AxisRefusal::Why;

/// Whether the command is a stop, which every caller may send.
bool stops(AxisCommand command) noexcept {
  return command == AxisCommand::kStop || command == AxisCommand::kHalt;
}

/// Whether the command concerns a touch probe: it moves nothing and needs no lease.
bool probes(AxisCommand command) noexcept {
  return command == AxisCommand::kTouchProbe || command == AxisCommand::kAbortTrigger;
}

/// Whether the command replaces the motion in progress once the axis has accepted it.
bool begins_motion(AxisCommand command) noexcept {
  switch (command) {
    case AxisCommand::kHome:
    case AxisCommand::kMoveAbsolute:
    case AxisCommand::kMoveRelative:
    case AxisCommand::kMoveAdditive:
    case AxisCommand::kMoveSuperimposed:
    case AxisCommand::kMoveVelocity:
    case AxisCommand::kFollow:
    case AxisCommand::kTorque:
    case AxisCommand::kHomeByProbe:
    case AxisCommand::kDriveMoveAbsolute:
    case AxisCommand::kDriveMoveRelative:
    case AxisCommand::kDriveMoveVelocity:
    case AxisCommand::kDriveRun:
      return true;
    default:
      return false;
  }
}

AxisRequest plain(AxisCommand command) {
  AxisRequest request;
  request.command = command;
  return request;
}

tl::unexpected<AxisRefusal> refused(Why why, std::string owner = {}) {
  AxisRefusal refusal;
  refusal.why = why;
  refusal.owner = std::move(owner);
  return tl::unexpected(std::move(refusal));
}

tl::unexpected<AxisRefusal> refused(const LeaseRefusal& lease) {
  return refused(lease.firm ? Why::kMovedTogether : Why::kOwned, lease.owner);
}

}  // namespace

AxisRequests::AxisRequests(const std::vector<motion::AxisConfig>& axes, const rt::Clock& clock,
                           std::function<void()> stop_all)
    : axes_(axes), clock_(clock), stop_all_(std::move(stop_all)), authority_(axes.size()) {}

void AxisRequests::open(motion::SingleAxes& axes) {
  const std::lock_guard guard(lock_);
  single_ = &axes;
}

void AxisRequests::attach(LineCouplings& couplings) {
  const std::lock_guard guard(lock_);
  couplings_ = &couplings;
}

void AxisRequests::occupy(const std::string& owner) {
  const std::lock_guard guard(lock_);
  together_ = true;
  LeaseTerms terms;
  terms.owner = owner;
  terms.take_over = true;
  terms.firm = true;
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) static_cast<void>(authority_.take(axis, terms));
}

void AxisRequests::close() {
  std::vector<Call> due;
  {
    const std::lock_guard guard(lock_);
    due = take_due_calls(false);
    single_ = nullptr;
    couplings_ = nullptr;
    together_ = false;
    pending_.clear();
    auto rest = take_due_calls(true);
    std::move(rest.begin(), rest.end(), std::back_inserter(due));
  }
  call_back(std::move(due));
}

void AxisRequests::guard(GroupGuard* groups) {
  const std::lock_guard guard(lock_);
  groups_ = groups;
}

void AxisRequests::note(EventFacts facts) {
  const std::lock_guard guard(lock_);
  events_.push_back(std::move(facts));
}

std::vector<EventFacts> AxisRequests::take_events() {
  const std::lock_guard guard(lock_);
  return std::exchange(events_, {});
}

std::optional<std::size_t> AxisRequests::find(std::string_view name) const noexcept {
  const auto found = std::find_if(axes_.begin(), axes_.end(), [name](const auto& axis) { return axis.name == name; });
  if (found == axes_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - axes_.begin());
}

AxisRequests::Submitted AxisRequests::submit(const AxisCaller& caller, std::size_t axis, const AxisRequest& request) {
  const std::lock_guard guard(lock_);
  if (axis >= axes_.size()) return refused(Why::kNotRunning);
  auto submitted = try_to_submit(caller, axis, request);
  events::AxisRequested asked{caller.name, events::event_axis(axes_[axis]), request, {}, {}};
  if (!submitted) asked.refusal = submitted.error();
  if (!caller.quiet) events_.emplace_back(std::move(asked));
  return submitted;
}

AxisRequests::Submitted AxisRequests::submit(const AxisCaller& caller, std::size_t axis, const CouplingOrder& order) {
  const std::lock_guard guard(lock_);
  if (axis >= axes_.size()) return refused(Why::kNotRunning);
  auto submitted = try_to_couple(caller, axis, order);
  events::AxisRequested asked{
      caller.name, events::event_axis(axes_[axis]), plain(AxisCommand::kFollow), {}, order.text};
  if (!submitted) asked.refusal = submitted.error();
  if (!caller.quiet) events_.emplace_back(std::move(asked));
  return submitted;
}

AxisRequests::Submitted AxisRequests::try_to_couple(const AxisCaller& caller, std::size_t axis,
                                                    const CouplingOrder& order) {
  if (together_) return refused(Why::kMovedTogether, authority_.owner_of(axis));
  if (single_ == nullptr) return refused(Why::kNotRunning);
  if (couplings_ == nullptr || !couplings_->has(axis)) return refused(Why::kNoMaster);
  const bool changes = order.kind == CouplingOrder::Kind::kOut || order.kind == CouplingOrder::Kind::kPhase;
  if (changes && !couplings_->coupled(axis)) return refused(Why::kNotCoupled);
  const auto access = permission(caller, axis, AxisCommand::kFollow);
  if (!access) return tl::unexpected(access.error());
  const auto number = couplings_->submit(axis, order);
  if (number == 0) {
    if (*access == Access::kNewLease) authority_.release(axis, caller.name);
    return refused(Why::kTooMany);
  }
  pending_.push_back(
      {number, axis, caller, plain(AxisCommand::kFollow), *access == Access::kTakesOver, false, order.text});
  return number;
}

tl::expected<std::uint64_t, AxisRefusal> AxisRequests::acquire(const AxisCaller& caller, std::size_t axis) {
  const std::lock_guard guard(lock_);
  if (axis >= axes_.size() || (single_ == nullptr && !together_)) return refused(Why::kNotRunning);
  const auto taken = authority_.take(axis, terms_of(caller));
  if (!taken) return refused(taken.error());
  return *taken;
}

bool AxisRequests::holds(const AxisCaller& caller, std::size_t axis) const {
  return caller.lease && authority_.goes_on(axis, *caller.lease) && authority_.holds(axis, caller.name);
}

void AxisRequests::give_back(const std::string& caller, std::size_t axis) {
  const std::lock_guard guard(lock_);
  if (!authority_.holds(axis, caller)) return;
  stop_axis(axis);
  authority_.release(axis, caller);
}

AxisRequests::Submitted AxisRequests::try_to_submit(const AxisCaller& caller, std::size_t axis,
                                                    const AxisRequest& request) {
  if (single_ == nullptr && !together_) return refused(Why::kNotRunning);
  if (together_ && stops(request.command)) {
    stop_all_();
    return kRunEnded;
  }
  const auto report = single_ != nullptr ? single_->axis_report(axis) : motion::AxisReport{};
  if (auto wrong = check_request(axes_[axis], report, request)) return tl::unexpected(std::move(*wrong));
  // Also for a caller with the name of the source that moves them: there are no single axes to ask.
  if (together_) return refused(Why::kMovedTogether, authority_.owner_of(axis));
  const auto access = permission(caller, axis, request.command);
  if (!access) return tl::unexpected(access.error());
  const auto number = single_->submit(axis, request);
  if (number == 0) {
    if (*access == Access::kNewLease) authority_.release(axis, caller.name);
    return refused(Why::kTooMany);
  }
  pending_.push_back({number, axis, caller, request, *access == Access::kTakesOver});
  return number;
}

/// Takes the lease of an axis without owner. An axis of another owner stays with it until settle_take_overs().
AxisRequests::Permission AxisRequests::permission(const AxisCaller& caller, std::size_t axis, AxisCommand command) {
  if (stops(command)) return Access::kOpen;
  if (probes(command)) return probe_permission(caller, axis, command);
  if (caller.lease && !holds(caller, axis)) return refused(Why::kNoLease);
  const auto owner = authority_.owner_of(axis);
  auto terms = terms_of(caller);
  if (!owner.empty() && owner != caller.name && takes_over(caller, axis)) {
    terms.take_over = true;
    if (const auto free = authority_.check(axis, terms); !free) return refused(free.error());
    return Access::kTakesOver;
  }
  terms.take_over = false;
  if (const auto taken = authority_.take(axis, terms); !taken) return refused(taken.error());
  return owner.empty() ? Access::kNewLease : Access::kOpen;
}

/// Any caller may switch a touch probe off; only a caller with `take_over` may replace the probe of another caller.
AxisRequests::Permission AxisRequests::probe_permission(const AxisCaller& caller, std::size_t axis,
                                                        AxisCommand command) const {
  if (command == AxisCommand::kAbortTrigger || caller.take_over) return Access::kOpen;
  for (const auto& pending : pending_) {
    const bool his = pending.caller.name == caller.name;
    if (his || pending.axis != axis || pending.request.command != AxisCommand::kTouchProbe) continue;
    if (!progress_of(axis, pending.number).report.over()) return refused(Why::kProbeTaken, pending.caller.name);
  }
  return Access::kOpen;
}

/// Whether the caller takes the axis over: by this request, or by an earlier request that the axis has not processed
/// yet.
bool AxisRequests::takes_over(const AxisCaller& caller, std::size_t axis) const {
  return caller.take_over || std::any_of(pending_.begin(), pending_.end(), [&](const Pending& pending) {
           return pending.takes_over && pending.axis == axis && pending.caller.name == caller.name;
         });
}

LeaseTerms AxisRequests::terms_of(const AxisCaller& caller) const {
  LeaseTerms terms;
  terms.owner = caller.name;
  if (caller.keep_alive) terms.until = clock_.now() + *caller.keep_alive;
  return terms;
}

/// Gives axes to the callers that take them over, once the axes have accepted the requests.
void AxisRequests::settle_take_overs() {
  if (single_ == nullptr) return;
  for (auto& pending : pending_) {
    const auto phase =
        pending.takes_over ? progress_of(pending.axis, pending.number).report.phase : RequestPhase::kWaiting;
    if (phase == RequestPhase::kWaiting) continue;
    pending.takes_over = false;
    const bool taken =
        phase == RequestPhase::kActive || phase == RequestPhase::kReached || phase == RequestPhase::kDone;
    if (!taken) continue;
    if (pending.caller_left) {
      if (begins_motion(pending.request.command)) stop_axis(pending.axis);
      continue;
    }
    auto terms = terms_of(pending.caller);
    terms.take_over = true;
    if (std::find(leaving_.begin(), leaving_.end(), terms.owner) != leaving_.end()) terms.until.reset();
    static_cast<void>(authority_.take(pending.axis, terms));
  }
}

AxisProgress AxisRequests::progress(std::size_t axis, std::uint64_t request) const {
  const std::lock_guard guard(lock_);
  return progress_of(axis, request);
}

AxisProgress AxisRequests::progress_of(std::size_t axis, std::uint64_t request) const {
  if (request == kRunEnded) return {{RequestPhase::kDone, AxisError::kNone}, {}, {}, true};
  if (single_ == nullptr) {
    AxisRefusal refusal;
    return {{RequestPhase::kAborted, AxisError::kNone}, refusal, {}, false};
  }
  const bool taken = single_->taken(request);  // before the report: a request that is taken has its refusal there
  AxisProgress progress{single_->report(request), {}, {}, false};
  if (couplings_ != nullptr && couplings_->has(axis))
    progress.report = couplings_->judge(axis, request, progress.report);
  if (progress.report.phase == RequestPhase::kDone) {
    const auto now = single_->axis_report(axis);
    if (now.recorded_request == request) progress.recorded_position = now.recorded_position;
    // The recorded position appears only at the end of the cycle in which the request is done.
    if (now.recorded_request < request && is_probe(request)) progress.report.phase = RequestPhase::kActive;
  }
  progress.accepted = accepted(axis, request, progress.report.phase, taken);
  if (progress.report.error == AxisError::kNone) return progress;
  auto& refusal = progress.refusal.emplace();
  refusal.why = Why::kByAxis;
  refusal.error = progress.report.error;
  const auto report = single_->axis_report(axis);
  const bool coupling = couplings_ != nullptr && couplings_->has(axis);
  if (coupling && refusal.error == AxisError::kFollowing && couplings_->is_order(axis, request)) {
    refusal.why = Why::kCoupling;
    refusal.coupling = couplings_->refusal(axis);
  }
  if (coupling && LineCouplings::is_phase(request)) refusal.why = Why::kNotCoupled;
  if (refusal.error == AxisError::kFault) refusal.error_code = report.error_code;
  if (const auto gantry = single_->gantry_of(axis)) {
    refusal.skew = GantrySkew{single_->gantry_report(*gantry).stopped_at, single_->gantry_settings(*gantry).skew_limit};
  }
  const auto range = range_of_requests(axes_[axis], report);
  if (refusal.error != AxisError::kOutsideRange || !range) return progress;
  refusal.software_limits = true;
  refusal.lowest = range->min;
  refusal.highest = range->max;
  return progress;
}

bool AxisRequests::accepted(std::size_t axis, std::uint64_t request, RequestPhase phase, bool taken) const {
  switch (phase) {
    case RequestPhase::kWaiting:
      return taken;
    case RequestPhase::kActive:
      return !LineCouplings::is_phase(request) || couplings_->phase_taken(axis, request);
    case RequestPhase::kReached:
    case RequestPhase::kDone:
      return true;
    case RequestPhase::kUnknown:
    case RequestPhase::kAborted:
    case RequestPhase::kError:
      break;
  }
  return false;
}

/// Whether the request is a touch probe that is still pending.
bool AxisRequests::is_probe(std::uint64_t request) const {
  return std::any_of(pending_.begin(), pending_.end(), [request](const Pending& pending) {
    return pending.number == request && pending.request.command == AxisCommand::kTouchProbe;
  });
}

AxisProgress AxisRequests::wait(std::size_t axis, std::uint64_t request, std::chrono::nanoseconds limit) const {
  // A sum of the time and the greatest duration would overflow.
  constexpr std::chrono::nanoseconds kLongest = std::chrono::hours{24 * 365};
  const auto end = std::chrono::steady_clock::now() + std::min(limit, kLongest);
  std::unique_lock lock(lock_);
  while (!has_settled(progress_of(axis, request).report.phase)) {
    if (watched_.wait_until(lock, end) == std::cv_status::timeout) break;
  }
  return progress_of(axis, request);
}

void AxisRequests::when_settled(std::size_t axis, std::uint64_t request, Settled settled) {
  const std::lock_guard guard(lock_);
  calls_.push_back({axis, request, std::move(settled), {}});
}

/// Removes the calls whose requests have settled. `all`: the others as well, because the line goes out of operation.
std::vector<AxisRequests::Call> AxisRequests::take_due_calls(bool all) {
  for (auto& call : calls_) call.progress = progress_of(call.axis, call.request);
  const auto due = std::stable_partition(calls_.begin(), calls_.end(), [all](const Call& call) {
    return !all && !has_settled(call.progress.report.phase);
  });
  std::vector<Call> taken(std::make_move_iterator(due), std::make_move_iterator(calls_.end()));
  calls_.erase(due, calls_.end());
  return taken;
}

/// Wakes the threads in wait(), and makes the calls without the lock.
void AxisRequests::call_back(std::vector<Call> calls) {
  watched_.notify_all();
  for (const auto& call : calls) call.settled(call.progress);
}

AxisStatus AxisRequests::status(std::size_t axis) const {
  const std::lock_guard guard(lock_);
  AxisStatus status{events::event_axis(axes_.at(axis)), authority_.owner_of(axis), {}, {}};
  if (single_ != nullptr) status.report = single_->axis_report(axis);
  if (couplings_ != nullptr && couplings_->has(axis)) status.coupling = couplings_->status(axis);
  return status;
}

void AxisRequests::keep_alive(const AxisCaller& caller) {
  const std::lock_guard guard(lock_);
  settle_take_overs();
  if (caller.keep_alive) authority_.prolong(caller.name, clock_.now() + *caller.keep_alive);
}

void AxisRequests::leave(const std::string& caller, bool stop) {
  const std::lock_guard guard(lock_);
  settle_take_overs();
  if (!stop) {
    authority_.prolong(caller, std::nullopt);
    leaving_.push_back(caller);
    watch_leaving();
    return;
  }
  for (auto& pending : pending_) {
    if (pending.caller.name == caller) drop(pending);
  }
  authority_.release_all(caller);
}

/// Ends a pending request because its caller leaves.
void AxisRequests::drop(Pending& pending) {
  const auto progress = progress_of(pending.axis, pending.number);
  if (pending.request.command == AxisCommand::kTouchProbe) {
    if (single_ != nullptr && !progress.report.over())
      static_cast<void>(single_->submit(pending.axis, plain(AxisCommand::kAbortTrigger)));
  } else if (pending.takes_over) {
    pending.caller_left = true;
  } else if (authority_.holds(pending.axis, pending.caller.name)) {
    // An axis that another caller has taken over continues to move.
    stop_axis(pending.axis);
  }
}

void AxisRequests::watch() {
  std::vector<Call> due;
  {
    const std::lock_guard guard(lock_);
    settle_take_overs();
    watch_leases();
    // Before watch_requests(), which forgets the requests that are over.
    due = take_due_calls(false);
    watch_requests();
    watch_leaving();
  }
  call_back(std::move(due));
}

void AxisRequests::watch_leases() {
  for (auto& loss : authority_.losses(clock_.now())) {
    if (loss.taken_by.empty()) stop_axis(loss.axis);
    events_.emplace_back(events::AxisLeaseLost{axes_[loss.axis].name, std::move(loss.owner), std::move(loss.taken_by)});
  }
}

/// Only a stop can end homing (PLCopen part 1, state diagram); the stop is released at once. An axis that is at rest
/// gets the halt as well: it ends motions that are still queued.
void AxisRequests::stop_axis(std::size_t axis) {
  if (single_ == nullptr || (groups_ != nullptr && groups_->bring_to_rest(axis))) return;
  if (single_->axis_report(axis).state == PlcopenState::kHoming) {
    static_cast<void>(single_->submit(axis, plain(AxisCommand::kStop)));
    static_cast<void>(single_->submit(axis, plain(AxisCommand::kReleaseStop)));
    return;
  }
  static_cast<void>(single_->submit(axis, plain(AxisCommand::kHalt)));
}

void AxisRequests::watch_requests() {
  if (single_ == nullptr) return;
  std::erase_if(pending_, [this](Pending& pending) {
    auto progress = progress_of(pending.axis, pending.number);
    if (!progress.report.over() && progress.report.phase != RequestPhase::kUnknown) return false;
    auto axis = events::event_axis(axes_[pending.axis]);
    if (progress.refusal && !pending.caller.quiet) {
      events_.emplace_back(events::AxisRequestFailed{std::move(pending.caller.name), std::move(axis), pending.request,
                                                     std::move(*progress.refusal), std::move(pending.coupling)});
    } else if (progress.recorded_position) {
      events_.emplace_back(events::AxisProbed{std::move(pending.caller.name), std::move(axis), pending.request,
                                              *progress.recorded_position});
    }
    return true;
  });
}

void AxisRequests::watch_leaving() {
  std::erase_if(leaving_, [this](const std::string& caller) {
    const auto his = [&](const Pending& pending) { return pending.caller.name == caller; };
    if (std::any_of(pending_.begin(), pending_.end(), his)) return false;
    if (groups_ != nullptr && groups_->waits_for(caller)) return false;
    authority_.release_all(caller);
    return true;
  });
}

}  // namespace driveline::runtime
