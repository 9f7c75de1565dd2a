#include "driveline/canopen_master/node_supervisor.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMostEvents = 256;   ///< events that are kept until they are taken; older ones are dropped
constexpr std::uint64_t kTwinAnswers = 2;  ///< answers without a request, before two devices are suspected

}  // namespace

NodeSupervisor::NodeSupervisor(NodePlan plan, std::size_t number, const LineFacts& line,
                               const SupervisorSettings& settings)
    : number_(number),
      settings_(settings),
      boot_(std::move(plan), number, line),
      watch_(boot_.plan().error_control, boot_.plan().id) {}

MasterEvent& NodeSupervisor::tell(MasterEvent::Kind kind, nanoseconds time) {
  if (events_.size() >= kMostEvents) events_.pop_front();
  MasterEvent event;
  event.kind = kind;
  event.node = number_;
  event.id = plan().id;
  event.time = time;
  return events_.emplace_back(event);
}

std::optional<MasterEvent> NodeSupervisor::take_event() {
  if (events_.empty()) return std::nullopt;
  auto event = events_.front();
  events_.pop_front();
  return event;
}

void NodeSupervisor::boot(nanoseconds now) {
  view_.phase = NodePhase::kBooting;
  boot_.begin(BootFrom::kReset, now);
}

void NodeSupervisor::watch(nanoseconds now) {
  watching_ = true;
  // The probe of the boot was the first answer to node guarding: the toggle bit goes on from there.
  if (view_.phase == NodePhase::kConfigured) watch_.begin(now, false);
}

void NodeSupervisor::start(nanoseconds now) {
  wanted_ = true;
  if (view_.phase != NodePhase::kConfigured) return;
  view_.phase = NodePhase::kStarting;
  view_.step = BootStep::kStart;
  command_ = NmtRequest{NmtCommand::kStart, plan().id}.frame();
  deadline_ = now + plan().timeouts.start + plan().error_control.heartbeat + plan().error_control.guard_time;
}

void NodeSupervisor::release(nanoseconds /*now*/) {
  const bool reachable = view_.phase == NodePhase::kConfigured || view_.phase == NodePhase::kStarting ||
                         view_.phase == NodePhase::kOperational;
  releasing_ = true;
  wanted_ = false;
  probing_ = false;
  watch_.end();
  view_.phase = NodePhase::kReleased;
  command_ = NmtRequest{NmtCommand::kEnterPreOperational, plan().id}.frame();
  boot_.begin_release();
  if (!reachable) boot_.sdo().clear();
}

void NodeSupervisor::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (frame.kind == FrameKind::kData && frame.identifier == Identifier{predefined::kErrorControl + plan().id}) {
    if (const auto message = ErrorControl::decode(frame.payload())) take_state(*message, received.time);
  }
  if (frame.kind == FrameKind::kData && frame.identifier == Identifier{predefined::kEmergency + plan().id}) {
    if (const auto message = Emergency::decode(frame.payload())) take_emergency(*message, received.time);
  }
  boot_.receive(received);
  look_for_twin(received.time);
}

void NodeSupervisor::take_emergency(const Emergency& message, nanoseconds time) {
  // An EMCY message is told, and changes nothing: whether the node works is what its state and its PDOs show. One with
  // code 0000h says that an error has gone (CiA 301 7.2.7.1).
  const bool gone = message.code == emergency_code::kNoError;
  view_.emergency = message;
  if (!gone) ++view_.emergencies;
  tell(gone ? MasterEvent::Kind::kErrorReset : MasterEvent::Kind::kEmergency, time).emergency = message;
}

void NodeSupervisor::take_state(const ErrorControl& message, nanoseconds time) {
  const bool boot_up = message.state == NmtState::kInitialising;
  ++(boot_up ? view_.boot_ups : view_.heartbeats);
  // A node that has booted is in Pre-operational (CiA 301 7.3.2.1).
  view_.state = boot_up ? NmtState::kPreOperational : message.state;
  view_.heard = time;
  if (!watch_.receive(message, time) && watching_ && !releasing_) tell(MasterEvent::Kind::kGuardToggle, time);
  if (boot_up) watch_.restarted();
  // A boot that is under way sees the message itself.
  if (releasing_ || view_.phase == NodePhase::kBooting || probing_) return;
  if (boot_up) return rebooted(time);
  judge_state(message.state, time);
}

void NodeSupervisor::rebooted(nanoseconds time) {
  if (view_.phase != NodePhase::kNotSeen) tell(MasterEvent::Kind::kNodeRebooted, time);
  recover(BootFrom::kBootUp, time);
}

void NodeSupervisor::judge_state(NmtState state, nanoseconds time) {
  switch (view_.phase) {
    case NodePhase::kStarting:
      if (state == NmtState::kOperational) return became_operational(time);
      // The command was lost, or another master is at work.
      if (!command_) command_ = NmtRequest{NmtCommand::kStart, plan().id}.frame();
      return;
    case NodePhase::kOperational:
      if (state == NmtState::kOperational) return;
      tell(MasterEvent::Kind::kWrongState, time).state = state;
      return recover(BootFrom::kRunning, time);
    case NodePhase::kNotSeen:
    case NodePhase::kLost:
      return recover(BootFrom::kRunning, time);
    default:
      return;
  }
}

void NodeSupervisor::recover(BootFrom from, nanoseconds now) {
  if (!watching_) return;
  const bool given_up = !settings_.recover && view_.phase != NodePhase::kNotSeen;
  // A node that goes on watches the master, too: without remote frames its life guarding would run out.
  if (given_up || from != BootFrom::kRunning) watch_.end();
  if (given_up) {
    view_.phase = NodePhase::kLost;
    deadline_ = nanoseconds::max();
    return;
  }
  view_.phase = NodePhase::kBooting;
  probing_ = false;
  boot_.begin(from, now);
}

void NodeSupervisor::lose(nanoseconds now) {
  tell(MasterEvent::Kind::kNodeLost, now).waited_ms =
      static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::milliseconds>(watch_.patience()).count());
  watch_.end();
  view_.phase = NodePhase::kLost;
  deadline_ = settings_.recover ? now + settings_.retry_pause : nanoseconds::max();
}

void NodeSupervisor::advance(nanoseconds now) {
  boot_.advance(now);
  look_for_twin(now);
  switch (view_.phase) {
    case NodePhase::kBooting:
      return advance_boot(now);
    case NodePhase::kStarting:
      return advance_start(now);
    case NodePhase::kConfigured:
    case NodePhase::kOperational:
      if (watch_.missing(now)) lose(now);
      return;
    case NodePhase::kLost:
    case NodePhase::kFailed:
      return keep_trying(now);
    case NodePhase::kNotSeen:
    case NodePhase::kReleased:
      return;
  }
}

/// A node that is lost, or whose boot failed, is asked from time to time: its boot-up message may have been lost.
void NodeSupervisor::keep_trying(nanoseconds now) {
  if (probing_) {
    const auto step = boot_.step();
    if (!boot_.done() && (step == BootStep::kReset || step == BootStep::kDeviceType)) return;
    probing_ = false;
    if (boot_.done() && boot_.error() && boot_.error()->kind == NodeErrorKind::kAbsent) {
      deadline_ = now + settings_.retry_pause;
      return;
    }
    view_.phase = NodePhase::kBooting;
    return advance_boot(now);
  }
  if (!watching_ || !settings_.recover || now < deadline_) return;
  probing_ = true;
  boot_.begin(BootFrom::kRunning, now);
}

void NodeSupervisor::advance_boot(nanoseconds now) {
  view_.step = boot_.step();
  if (!boot_.done()) return;
  view_.identity = boot_.identity();
  if (boot_.error()) return boot_failed(now);
  view_.phase = NodePhase::kConfigured;
  view_.error.reset();
  seen_ = true;
  told_.reset();
  if (watching_) watch_.begin(now, false);
  if (wanted_) start(now);
}

void NodeSupervisor::boot_failed(nanoseconds now) {
  const auto& error = *boot_.error();
  const bool absent = error.kind == NodeErrorKind::kAbsent;
  watch_.end();
  deadline_ = now + settings_.retry_pause;
  view_.error = error;
  if (absent && !seen_ && plan().optional) {
    view_.phase = NodePhase::kNotSeen;
    view_.error.reset();
    joins_ = true;
    return;
  }
  const bool silent = absent || (error.kind == NodeErrorKind::kRequestFailed && error.step == BootStep::kDeviceType);
  view_.phase = silent && seen_ ? NodePhase::kLost : NodePhase::kFailed;
  if (!watching_ || told_ == error) return;
  told_ = error;
  tell(MasterEvent::Kind::kRecoveryFailed, now).error = error;
}

void NodeSupervisor::advance_start(nanoseconds now) {
  if (command_) return;
  // A node without error control is assumed to obey: its PDOs will show it.
  if (!watch_.tells_state()) return became_operational(now);
  if (now < deadline_) return;
  NodeError error{NodeErrorKind::kWrongState, number_, plan().id, BootStep::kStart};
  error.wanted_state = NmtState::kOperational;
  error.found_state = view_.state.value_or(NmtState::kPreOperational);
  error.waited_ms = static_cast<std::uint32_t>(plan().timeouts.start.count());
  view_.phase = NodePhase::kFailed;
  view_.error = error;
  deadline_ = now + settings_.retry_pause;
  if (told_ == error) return;
  told_ = error;
  tell(MasterEvent::Kind::kRecoveryFailed, now).error = error;
}

void NodeSupervisor::became_operational(nanoseconds time) {
  view_.phase = NodePhase::kOperational;
  if (was_operational_) {
    ++view_.recoveries;
    tell(MasterEvent::Kind::kNodeBack, time);
  } else if (joins_) {
    tell(MasterEvent::Kind::kNodeJoined, time);
  }
  was_operational_ = true;
}

void NodeSupervisor::look_for_twin(nanoseconds now) {
  if (twin_told_ || boot_.sdo().unasked() < kTwinAnswers) return;
  twin_told_ = true;
  tell(MasterEvent::Kind::kDoubleAnswers, now);
}

std::optional<Frame> NodeSupervisor::outgoing(nanoseconds now) const {
  if (command_) return command_;
  if (auto frame = boot_.outgoing()) return frame;
  return watch_.outgoing(now);
}

void NodeSupervisor::sent(SendStatus status, nanoseconds now) {
  if (status == SendStatus::kBusy) return;
  if (command_) return command_.reset();
  if (boot_.outgoing()) return boot_.sent(status, now);
  watch_.sent(now);
}

}  // namespace driveline::canopen
