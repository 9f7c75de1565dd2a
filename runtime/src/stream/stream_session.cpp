#include "stream/stream_session.hpp"

#include <cmath>
#include <utility>

namespace driveline::runtime {
namespace {

using stream::EndReason;
using stream::MotionState;
using stream::RecordKind;
using stream::Refusal;
using stream::SessionState;

/// Time for a client to map the memory and to calculate its first setpoint.
constexpr auto kTimeToBegin = std::chrono::seconds{1};
constexpr std::uint64_t kStatusRecords = 64;
/// Share of the highest velocity that counts as standstill.
constexpr double kStandstill = 1e-6;

std::vector<stream::AxisBounds> bounds_of(const std::vector<StreamSession::Member>& members) {
  std::vector<stream::AxisBounds> bounds;
  for (const auto& member : members) bounds.push_back(member.bounds);
  return bounds;
}

/// Without additional delay: the client sends ahead, or the curve starts before the first setpoint.
trajectory::StreamSettings curve_settings(const ClientStreamSettings& settings, std::chrono::nanoseconds period) {
  trajectory::StreamSettings curve;
  curve.method = settings.method;
  curve.period_s = std::chrono::duration<double>(period).count();
  curve.max_ahead_s = std::chrono::duration<double>(StreamSession::kLongestAhead).count();
  curve.capacity = StreamSession::kSetpointsAhead;
  curve.coast_cycles = StreamSession::kCoastCycles;
  return curve;
}

std::vector<trajectory::FollowLimits> follow_limits(const std::vector<StreamSession::Member>& members) {
  std::vector<trajectory::FollowLimits> limits;
  for (const auto& bounds : bounds_of(members)) {
    limits.push_back(
        {{bounds.max_velocity, bounds.max_acceleration}, bounds.max_acceleration / StreamSession::kStopRiseSeconds});
  }
  return limits;
}

Refusal refusal_of(trajectory::StreamVerdict verdict) noexcept {
  using trajectory::StreamVerdict;
  switch (verdict) {
    case StreamVerdict::kAccepted:
      break;
    case StreamVerdict::kWrongCount:
      return Refusal::kAxisCount;
    case StreamVerdict::kNotFinite:
      return Refusal::kNotFinite;
    case StreamVerdict::kOutOfRange:
      return Refusal::kOutsideRange;
    case StreamVerdict::kDuplicate:
    case StreamVerdict::kOutOfOrder:
      return Refusal::kOutOfOrder;
    case StreamVerdict::kTooLate:
      return Refusal::kLate;
    case StreamVerdict::kTooFarAhead:
    case StreamVerdict::kOverrun:
      return Refusal::kTooFarAhead;
    case StreamVerdict::kGapTooLarge:
      return Refusal::kTimeGap;
  }
  return Refusal::kUnknownKind;
}

/// Whether an axis in this state may start to follow.
bool can_follow(MotionState state) noexcept {
  return state == MotionState::kStandstill || state == MotionState::kDiscreteMotion ||
         state == MotionState::kContinuousMotion;
}

}  // namespace

Result<std::unique_ptr<StreamSession>> StreamSession::make(std::vector<Member> members, bool power,
                                                           const ClientStreamSettings& settings,
                                                           std::chrono::nanoseconds period,
                                                           const AxisAuthority& authority, rt::SharedSealing sealing) {
  auto ring = rt::SharedRegion::create("driveline-setpoints", stream::setpoint_ring(kRingRecords), sealing);
  if (!ring) return fail(ErrorKind::kMachine, describe(ring.error()));
  auto broadcast = rt::SharedRegion::create("driveline-status", stream::status_broadcast(kStatusRecords));
  if (!broadcast) return fail(ErrorKind::kMachine, describe(broadcast.error()));
  return std::unique_ptr<StreamSession>(new StreamSession(std::move(members), power, settings, period, authority,
                                                          std::move(*ring), std::move(*broadcast)));
}

StreamSession::StreamSession(std::vector<Member> members, bool power, const ClientStreamSettings& settings,
                             std::chrono::nanoseconds period, const AxisAuthority& authority, rt::SharedRegion ring,
                             rt::SharedRegion broadcast)
    : members_(std::move(members)),
      power_(power),
      settings_(settings),
      authority_(authority),
      ring_(std::move(ring)),
      broadcast_(std::move(broadcast)),
      records_(ring_),
      statuses_(broadcast_),
      check_(bounds_of(members_)),
      curve_(curve_settings(settings, period), follow_limits(members_)),
      axes_(members_.size()),
      leases_(members_.size()),
      setpoints_(members_.size()),
      positions_(members_.size()) {
  for (std::size_t i = 0; i < members_.size(); ++i) give(i, members_[i].lease);
}

Result<void> StreamSession::close_to_writers() {
  if (auto closed = ring_.close_to_writers(); !closed) return fail(ErrorKind::kMachine, describe(closed.error()));
  return {};
}

void StreamSession::give(std::size_t member, std::uint64_t lease) noexcept {
  leases_[member].number.store(lease, std::memory_order_release);
  leases_[member].asked.store(false, std::memory_order_relaxed);
}

void StreamSession::request_end(EndReason reason) noexcept {
  auto none = EndReason::kNone;
  end_request_.compare_exchange_strong(none, reason, std::memory_order_relaxed);
}

void StreamSession::joined(std::size_t member) noexcept {
  auto& axis = axes_[member];
  axis.following = true;
  axis.wanted = false;
  axis.let_go = false;
}

void StreamSession::left(std::size_t member) noexcept {
  axes_[member].following = false;
}

const trajectory::AxisSetpoint* StreamSession::setpoint(std::size_t member) noexcept {
  if (!ending() && commands(member)) return &setpoints_[member];
  auto& axis = axes_[member];
  axis.following = false;
  axis.wanted = false;
  axis.let_go = true;
  return nullptr;
}

bool StreamSession::update(const motion::TaskCycle& cycle, StreamAxes& axes) noexcept {
  // A new curve would start at the present setpoints of the axes.
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const auto view = axes.view(members_[i].axis);
    check_.set_offset(i, view.offset);
    positions_[i] = axes_[i].following ? setpoints_[i].position : view.setpoint;
  }
  take_records(cycle.grid);
  watch(cycle.grid);
  advance(cycle.elapsed);
  command(axes);
  const bool over = ending() && at_rest(axes);
  if (over) status_record_.state = SessionState::kOver;
  publish(cycle, axes);
  return !over;
}

void StreamSession::take_records(std::chrono::nanoseconds now) noexcept {
  const auto count = records_.pop(batch_);
  for (const auto& record : std::span(batch_).first(count)) take(record);
  if (count > 0) heard_ = now;
  for (; breaches_ < records_.breaches(); ++breaches_) refuse(Refusal::kImpossibleIndex);
}

void StreamSession::take(const stream::SetpointRecord& record) noexcept {
  if (ending()) return;
  switch (record.kind) {
    case RecordKind::kSetpoint:
      take_setpoint(record);
      return;
    case RecordKind::kHeartbeat:
      return;
    case RecordKind::kFollow:
      follow_again();
      return;
    case RecordKind::kEnd:
      end(EndReason::kEnded);
      return;
  }
  refuse(Refusal::kUnknownKind);
}

void StreamSession::follow_again() noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    axes_[i].wanted = !axes_[i].following;
    if (axes_[i].wanted && !commands(i)) leases_[i].asked.store(true, std::memory_order_relaxed);
  }
}

void StreamSession::take_setpoint(const stream::SetpointRecord& record) noexcept {
  const auto verdict = check_.judge(record, newest_ ? &*newest_ : nullptr);
  if (verdict.remark) refuse(*verdict.remark);
  if (!verdict.taken) return note_fault(verdict);
  if (!stream_ns_) begin_at(record.time_ns);
  if (const auto refusal = push(record)) {
    refuse(*refusal);
    if (!newest_) stream_ns_.reset();
    return;
  }
  newest_ = record;
  ++status_record_.taken;
  status_record_.newest_ns = record.time_ns;
  status_record_.state = SessionState::kStreaming;
}

void StreamSession::note_fault(const SetpointCheck::Verdict& verdict) noexcept {
  if (!verdict.remark || !verdict.fault) return;
  auto& first = first_faults_[static_cast<std::size_t>(*verdict.remark)];
  if (first.known.load(std::memory_order_relaxed)) return;
  first.fault = *verdict.fault;
  first.known.store(true, std::memory_order_release);
}

/// Adds the setpoint to the curve. Returns why it was refused; none: it was accepted.
std::optional<Refusal> StreamSession::push(const stream::SetpointRecord& record) noexcept {
  std::array<trajectory::StreamPoint, stream::kMaxAxes> points{};
  for (std::size_t i = 0; i < members_.size(); ++i) {
    points[i] = {record.targets[i].position, record.targets[i].velocity, record.targets[i].acceleration};
  }
  const auto verdict = curve_.push(seconds(record.time_ns), std::span(points).first(members_.size()));
  if (verdict == trajectory::StreamVerdict::kAccepted) return std::nullopt;
  return refusal_of(verdict);
}

/// Starts a new curve, whose first setpoint is for this time.
void StreamSession::begin_at(std::int64_t time_ns) noexcept {
  begin_ns_ = time_ns - settings_.delay.count();
  stream_ns_ = begin_ns_;
  curve_.begin(0.0, positions_);
}

double StreamSession::seconds(std::int64_t time_ns) const noexcept {
  return 1e-9 * static_cast<double>(time_ns - begin_ns_);
}

/// Advances along the time axis of the client as the grid advances.
void StreamSession::advance(std::chrono::nanoseconds elapsed) noexcept {
  if (!stream_ns_) return;
  *stream_ns_ += elapsed.count();
  const auto before = curve_.state();
  const auto state = curve_.evaluate(seconds(*stream_ns_), setpoints_);
  using trajectory::StreamState;
  if (state == StreamState::kCoasting && before == StreamState::kFollowing && moving()) ++status_record_.starved;
  status_record_.detours = curve_.counters().detours;
  const bool used_up = newest_ && newest_->time_ns < *stream_ns_;
  if (state != StreamState::kAtRest || !used_up) return;
  if (!ending()) status_record_.state = SessionState::kStarved;
  stream_ns_.reset();
  newest_.reset();
}

bool StreamSession::moving() const noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (std::abs(setpoints_[i].velocity) > kStandstill * members_[i].bounds.max_velocity) return true;
  }
  return false;
}

void StreamSession::end(EndReason reason) noexcept {
  if (ending()) return;
  reason_ = reason;
  status_record_.reason = reason;
  status_record_.state = SessionState::kEnding;
  for (auto& lease : leases_) lease.asked.store(false, std::memory_order_relaxed);
}

void StreamSession::watch(std::chrono::nanoseconds now) noexcept {
  if (!heard_) heard_ = now + kTimeToBegin;
  if (now - *heard_ > settings_.keep_alive) end(EndReason::kSilent);
  if (const auto asked = end_request_.load(std::memory_order_relaxed); asked != EndReason::kNone) end(asked);
}

void StreamSession::command(StreamAxes& axes) noexcept {
  const bool power = std::exchange(power_, false);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (!commands(i)) {
      axes_[i].wanted = axes_[i].wanted && asks_for(i);
      continue;
    }
    const auto axis = members_[i].axis;
    const auto state = axes.view(axis).state;
    if (power && state == MotionState::kDisabled) axes.power_on(axis);
    if (std::exchange(members_[i].halt, false)) axes.halt(axis);
    const bool can = axes_[i].bound && can_follow(state);
    if (ending() || !stream_ns_ || !axes_[i].wanted || !can) continue;
    axes_[i].wanted = false;
    axes.follow(axis);
  }
}

bool StreamSession::at_rest(const StreamAxes& axes) const noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    // Axes that another client moves now do not matter.
    if (!axes_[i].bound || (!axes_[i].following && !commands(i))) continue;
    const auto state = axes.view(members_[i].axis).state;
    const bool stopping = axes_[i].let_go && state == MotionState::kDiscreteMotion;
    if (axes_[i].following || stopping || state == MotionState::kSynchronizedMotion) return false;
  }
  return true;
}

void StreamSession::publish(const motion::TaskCycle& cycle, const StreamAxes& axes) noexcept {
  auto& record = status_record_;
  record.cycle = cycle.cycle;
  record.grid_ns = cycle.grid.count();
  record.stream_ns = stream_ns_.value_or(record.stream_ns);
  record.axis_count = static_cast<std::uint32_t>(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const auto view = axes.view(members_[i].axis);
    const auto& inputs = cycle.axes[members_[i].axis].inputs();
    record.axes[i] = {.state = view.state,
                      .error = view.error,
                      .following = axes_[i].following ? 1U : 0U,
                      .leased = commands(i) ? 1U : 0U,
                      .setpoint = view.setpoint,
                      .position = inputs.position + view.offset,
                      .velocity = inputs.velocity,
                      .torque = inputs.torque};
  }
  statuses_.push(record);
}

}  // namespace driveline::runtime
