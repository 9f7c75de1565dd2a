#include "driveline/canopen_master/node_boot.hpp"

#include "boot_script.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

constexpr unsigned kMostBootUps = 5;  ///< boot-up messages of a node while it is configured
constexpr unsigned kMostPushes = 3;   ///< NMT commands to a node that stays in a wrong state

SdoOptions options_of(const NodePlan& plan) {
  SdoOptions options;
  options.answer_timeout = plan.timeouts.sdo;
  return options;
}

std::uint32_t whole_milliseconds(nanoseconds time) noexcept {
  return static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::milliseconds>(time).count());
}

}  // namespace

LineFacts LineFacts::of(const MasterPlan& plan) noexcept {
  const auto period = std::chrono::duration_cast<std::chrono::microseconds>(plan.period);
  return {plan.sync_identifier, static_cast<std::uint32_t>(period.count()), plan.master_id};
}

NodeBoot::NodeBoot(NodePlan plan, std::size_t number, const LineFacts& line)
    : plan_(std::move(plan)), number_(number), line_(line), sdo_(plan_.id, options_of(plan_)) {}

void NodeBoot::begin(BootFrom from, nanoseconds /*now*/) {
  sdo_.clear();
  error_.reset();
  frame_.reset();
  from_ = from;
  boot_ups_ = 0;
  pushes_ = 0;
  deadline_ = nanoseconds::max();
  step_ = BootStep::kReset;
  if (from != BootFrom::kReset) return ask();
  sdo_.forget_node();
  state_ = State::kAwaitingBootUp;
  queue(NmtRequest{NmtCommand::kResetCommunication, plan_.id}.frame());
}

void NodeBoot::begin_release() {
  sdo_.clear();
  error_.reset();
  frame_.reset();
  // Restarts do not matter any more, and no state is a wrong one.
  state_ = State::kReleasing;
  step_ = BootStep::kErrorControl;
  BootScript(*this).release();
}

void NodeBoot::ask() {
  state_ = State::kAsking;
  step_ = BootStep::kDeviceType;
  deadline_ = nanoseconds::max();
  if (from_ == BootFrom::kBootUp) {
    sdo_.forget_node();
  } else {
    // SDOs are not answered in Stopped, and a mapping cannot be changed in Operational.
    queue(NmtRequest{NmtCommand::kEnterPreOperational, plan_.id}.frame());
  }
  BootScript(*this).configure();
}

void NodeBoot::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (sdo_.receive(frame, received.time)) return;
  if (frame.kind != FrameKind::kData || frame.identifier != Identifier{predefined::kErrorControl + plan_.id}) return;
  if (const auto message = ErrorControl::decode(frame.payload())) take_state(*message, received.time);
}

void NodeBoot::take_state(const ErrorControl& message, nanoseconds time) {
  if (state_ == State::kIdle || state_ == State::kDone) return;
  if (message.state == NmtState::kInitialising && state_ != State::kReleasing) return booted(time);
  if (state_ == State::kAwaitingBootUp || state_ == State::kReleasing) return;
  if (message.state != NmtState::kPreOperational) {
    if (++pushes_ <= kMostPushes) return queue(NmtRequest{NmtCommand::kEnterPreOperational, plan_.id}.frame());
    auto error = error_of(NodeErrorKind::kWrongState);
    error.found_state = message.state;
    return fail(error);
  }
  if (state_ != State::kProbing || frame_) return;
  state_ = State::kAsking;
  BootScript(*this).guarding();
}

void NodeBoot::booted(nanoseconds /*now*/) {
  if (++boot_ups_ > kMostBootUps) return fail(error_of(NodeErrorKind::kRestarts));
  from_ = BootFrom::kBootUp;
  frame_.reset();
  sdo_.clear();
  ask();
}

void NodeBoot::advance(nanoseconds now) {
  if (frame_) return;
  switch (state_) {
    case State::kAwaitingBootUp:
      if (deadline_ == nanoseconds::max()) deadline_ = now + plan_.timeouts.boot_up;
      // Some nodes were there before and send no boot-up message: an answer to 1000h will do.
      if (now >= deadline_) ask();
      break;
    case State::kAsking:
      sdo_.advance(now);
      if (state_ == State::kAsking && sdo_.idle()) probe(now);
      break;
    case State::kProbing:
      if (now < deadline_) break;
      fail([&] {
        auto error = error_of(NodeErrorKind::kNoGuarding);
        error.waited_ms = whole_milliseconds(plan_.timeouts.sdo);
        return error;
      }());
      break;
    case State::kReleasing:
      sdo_.advance(now);
      if (state_ == State::kReleasing && sdo_.idle()) state_ = State::kDone;
      break;
    case State::kIdle:
    case State::kDone:
      sdo_.advance(now);
      break;
  }
}

/// The first remote frame of node guarding, before the node watches the master: it shows that adapter and node can do
/// it.
void NodeBoot::probe(nanoseconds now) {
  const bool guarded = plan_.error_control.guard_time.count() > 0;
  if (guarded && deadline_ == nanoseconds::max()) {
    state_ = State::kProbing;
    deadline_ = now + plan_.timeouts.sdo;
    return queue(Frame::remote({predefined::kErrorControl + plan_.id}, ErrorControl::kSize));
  }
  state_ = State::kDone;
  step_ = BootStep::kConfigured;
}

std::optional<Frame> NodeBoot::outgoing() const {
  return frame_ ? frame_ : sdo_.outgoing();
}

void NodeBoot::sent(SendStatus status, nanoseconds now) {
  if (status == SendStatus::kBusy) return;
  if (status == SendStatus::kDown) {
    if (!done() && state_ != State::kIdle) fail(error_of(NodeErrorKind::kBusDown));
    frame_.reset();
    return sdo_.fail({ClientErrorKind::kDown, plan_.id});
  }
  if (!frame_) {
    if (status == SendStatus::kSent) return sdo_.sent(now);
    return sdo_.fail({ClientErrorKind::kNotCarried, plan_.id});
  }
  frame_.reset();
  if (state_ == State::kAwaitingBootUp) deadline_ = now + plan_.timeouts.boot_up;
  if (state_ == State::kProbing) {
    deadline_ = now + plan_.timeouts.sdo;
    if (status == SendStatus::kNotValid) fail(error_of(NodeErrorKind::kNoRemote));
  }
}

NodeError NodeBoot::error_of(NodeErrorKind kind, SdoObject object) const {
  NodeError error{kind, number_, plan_.id, step_};
  error.object = object;
  return error;
}

void NodeBoot::fail(NodeError error) {
  sdo_.clear();
  frame_.reset();
  state_ = State::kDone;
  error_ = error;
}

}  // namespace driveline::canopen
