#include "driveline/slaves/canopen/device.hpp"

#include <algorithm>

namespace driveline::slaves::cia301 {
namespace {

/// Communication profile area of the dictionary, which a reset of the communication restores.
constexpr std::uint16_t kFirstCommunicationObject = 0x1000;
constexpr std::uint16_t kLastCommunicationObject = 0x1FFF;

/// Reaction to a failure of the communication, 1029h:01 (CiA 301 7.5.2.26).
enum class ErrorBehaviour : std::uint8_t { kPreOperational = 0, kNoChange = 1, kStopped = 2 };

AccessPhase phase_of(NmtState state) noexcept {
  if (state == NmtState::kOperational) return AccessPhase::kOperating;
  return state == NmtState::kPreOperational ? AccessPhase::kConfiguring : AccessPhase::kClosed;
}

}  // namespace

Device::Device(ObjectDictionary& dictionary, Application& application, const DeviceOptions& options)
    : dictionary_(&dictionary),
      application_(&application),
      options_(options),
      error_control_(dictionary, outbox_),
      heartbeats_(dictionary),
      sync_(dictionary, outbox_),
      emergency_(dictionary, outbox_),
      sdo_(dictionary, *this, options_),
      pdos_(dictionary, application, emergency_, options_, outbox_),
      time_cob_id_(dictionary, 0x1012, 0),
      error_behaviour_(dictionary, 0x1029, 1) {
  if (options_.stores) store_.emplace(dictionary.table(), options_, application);
}

void Device::connected(can::Controller& controller) {
  outbox_.connect(controller);
  power_on();
}

void Device::power_on() {
  node_id_ = 0;
  nmt_.enter(NmtState::kInitialising);
  pending_ = Reset::kPowerOn;
}

void Device::restart_communication() noexcept {
  if (!pending_) pending_ = Reset::kCommunication;
}

/// Initialising (CiA 301 7.3.2.2): restores values, takes node-ID and bit rate. The boot-up message follows, when the
/// application has started, too.
void Device::reset(Reset reset, nanoseconds now) {
  pending_.reset();
  restart_controller(reset);
  outbox_.clear();
  nmt_queue_.clear();
  sdo_.cancel();
  pdos_.stop();
  node_id_ = 0;
  nmt_.enter(NmtState::kInitialising);
  application_->state_changed(nmt_.state(), now);
  restore(reset, now);
  const std::uint8_t node_id = application_->node_id(reset);
  next_node_id_ = node_id <= canopen::kMaxNodeId ? node_id : std::uint8_t{0};
  if (outbox_.controller() != nullptr) {
    if (const std::uint32_t rate = application_->bit_rate(reset); rate != 0) outbox_.controller()->set_bit_rate(rate);
    outbox_.controller()->recover(now);
  }
  boot_up_at_ = reset == Reset::kCommunication ? now : now + application_->start_up_time();
  if (boot_up_at_ <= now) boot_up(now);
}

/// A controller that is switched off and on again need not recover from bus off: otherwise the boot-up message is lost.
void Device::restart_controller(Reset reset) noexcept {
  can::Controller* controller = outbox_.controller();
  if (controller == nullptr) return;
  if (reset == Reset::kPowerOn) controller->restart();
  bus_off_ = controller->errors().state() == can::ErrorState::kBusOff;
}

/// What is reset has its stored values and no errors of its past.
void Device::restore(Reset reset, nanoseconds now) {
  const bool whole = reset != Reset::kCommunication;
  if (store_) {
    store_->restore(*dictionary_, whole ? 0 : kFirstCommunicationObject, whole ? 0xFFFF : kLastCommunicationObject);
  } else if (!whole) {
    application_->restore_communication();
  }
  emergency_.forget(whole ? kApplicationSource : kStackSource, kLastSource);
  if (whole) application_->restart(reset, now);
  emergency_.update_register();
}

/// Sends the boot-up message, and enters Pre-operational.
void Device::boot_up(nanoseconds now) {
  boot_up_at_ = kNever;
  if (next_node_id_ == 0) return;
  node_id_ = next_node_id_;
  add_node_id(*dictionary_, options_.node_relative, node_id_);
  const std::array<std::byte, Frame::kMaxLength> zeros{};
  outbox_.send(Frame::of(options_.boot_up + node_id_, std::span(zeros).first(options_.boot_up_length)));
  announced_ = false;
  error_control_.restart({options_.error_control + node_id_, false}, now);
  heartbeats_.restart();
  nmt_.enter(NmtState::kPreOperational);
  state_changed(now);
  sync_.restart(now);
  const auto* controller = outbox_.controller();
  if (controller != nullptr && controller->errors().state() == can::ErrorState::kPassive) {
    raise_stack_error(canopen::emergency_code::kErrorPassive, kStackSource, now);
  }
}

void Device::enter(NmtState state, nanoseconds now) {
  if (nmt_.state() != NmtState::kInitialising && nmt_.enter(state)) state_changed(now);
}

void Device::state_changed(nanoseconds now) {
  if (!nmt_.configurable()) sdo_.cancel();
  if (nmt_.operational()) {
    pdos_.start(now);
  } else {
    pdos_.stop();
  }
  application_->state_changed(nmt_.state(), now);
  emergency_.advance(tells_errors(), now);
}

void Device::receive_nmt(const Frame& frame, nanoseconds now) {
  if (options_.nmt_cycle.count() == 0) return nmt(frame, now);
  if (!nmt_queue_.add(frame)) nmt_.ignore();
  obey_at_ = (now / options_.nmt_cycle + 1) * options_.nmt_cycle;
}

/// A reset forgets the requests behind it, as a device that initialises ignores them.
void Device::obey_nmt(nanoseconds now) {
  obey_at_ = kNever;
  while (const auto frame = nmt_queue_.take()) nmt(*frame, now);
}

void Device::nmt(const Frame& frame, nanoseconds now) {
  switch (nmt_.request(frame.payload(), node_id_, application_->may_start())) {
    case NmtMachine::Action::kStateChanged:
      return state_changed(now);
    case NmtMachine::Action::kResetNode:
      return reset(Reset::kNode, now);
    case NmtMachine::Action::kResetCommunication:
      return reset(Reset::kCommunication, now);
    case NmtMachine::Action::kNone:
      return;
  }
}

void Device::receive(const Frame& frame, nanoseconds now) {
  now_ = now;
  if (node_id_ == 0 || frame.kind == canopen::FrameKind::kError) return;
  const bool base_data = frame.kind == canopen::FrameKind::kData && !frame.identifier.extended;
  if (base_data && frame.identifier.value == canopen::predefined::kNmt) return receive_nmt(frame, now);
  receive_error_control(frame, now);
  if (!nmt_.configurable()) return;
  if (base_data && frame.identifier.value == options_.sdo_request + node_id_) return sdo(frame, now);
  if (const auto message = sync_.receive(frame)) return sync(*message, now);
  receive_time(frame, now);
  pdos_.receive(frame, now);
}

void Device::receive_error_control(const Frame& frame, nanoseconds now) {
  if (frame.kind == canopen::FrameKind::kRemote) {
    if (frame.identifier == error_control_.identifier()) guarded(error_control_.remote(nmt_.state(), now), now);
    return;
  }
  constexpr std::uint32_t kFirst = canopen::predefined::kErrorControl;
  const std::uint32_t value = frame.identifier.value;
  if (frame.identifier.extended || value <= kFirst || value > kFirst + canopen::kMaxNodeId) return;
  const auto message = canopen::ErrorControl::decode(frame.payload());
  if (!message) return;
  monitored(heartbeats_.receive(static_cast<std::uint8_t>(value - kFirst), message->state, now), now);
}

void Device::receive_time(const Frame& frame, nanoseconds now) {
  const canopen::CobId cob_id = time_cob_id_.cob_id();
  if ((cob_id.raw & canopen::CobId::kConsumer) == 0 || frame.identifier != cob_id.identifier()) return;
  if (const auto time = canopen::TimeOfDay::decode(frame.payload())) application_->time(*time, now);
}

void Device::sync(const canopen::Sync& sync, nanoseconds now) {
  application_->advance(now);
  pdos_.apply(now);
  application_->sync(sync.counter, now);
  pdos_.sample(now);
}

void Device::answer_sdo(const SdoBytes& answer, nanoseconds now) {
  const Frame frame = Frame::of(options_.sdo_answer + node_id_, answer);
  if (options_.sdo_delay.count() == 0) return outbox_.send(frame);
  outbox_.send_at(now + options_.sdo_delay, frame);
}

void Device::sdo(const Frame& frame, nanoseconds now) {
  if (const auto answer = sdo_.handle(frame.payload(), phase_of(nmt_.state()))) {
    answer_sdo(*answer, now);
  } else if (const auto segment = sdo_.next_segment()) {
    answer_sdo(*segment, now);
  }
}

void Device::transmitted(const Frame& frame, nanoseconds now) {
  now_ = now;
  if (!std::exchange(announced_, true)) emergency_.advance(tells_errors(), now);
  if (frame.identifier != canopen::Identifier{options_.sdo_answer + node_id_, false}) return;
  // The segments of a sub-block follow one another, one at a time in the queue.
  if (const auto segment = sdo_.next_segment()) outbox_.send(Frame::of(options_.sdo_answer + node_id_, *segment));
}

SdoResult<void> Device::accept(const EntryRow& row, std::uint64_t raw) {
  const auto value = static_cast<std::uint32_t>(raw);
  auto result = pdos_.check(row, raw);
  const auto also = [&](auto&& check) {
    if (result) result = check();
  };
  also([&] { return heartbeats_.check(row, value); });
  also([&] { return sync_.check(row, value); });
  also([&] { return emergency_.check(row, value); });
  also([&] { return application_->accept(row, raw); });
  also([&] { return store_ ? store_->accept(row, value, *dictionary_, node_id_) : SdoResult<void>{}; });
  return result;
}

void Device::written(const EntryRow& row) {
  error_control_.written(row, nmt_.state(), now_);
  heartbeats_.written(row);
  sync_.written(row, now_);
  emergency_.written(row);
  pdos_.written(row, now_);
  application_->written(row);
}

void Device::raise(const Emergency& emergency, nanoseconds now) {
  emergency_.raise(emergency, kApplicationSource, tells_errors(), now);
}

void Device::clear(std::uint16_t code, nanoseconds now) {
  emergency_.clear(code, kApplicationSource, tells_errors(), now);
}

void Device::raise_stack_error(std::uint16_t code, std::uint8_t source, nanoseconds now) {
  const std::uint8_t bits = canopen::error_register::kGeneric | canopen::error_register::kCommunication;
  emergency_.raise({code, bits, {}}, source, tells_errors(), now);
}

void Device::raise_failure(std::uint16_t code, std::uint8_t source, nanoseconds now) {
  if (options_.failure_emergencies) raise_stack_error(code, source, now);
}

bool Device::persists(CommunicationEvent event) const noexcept {
  switch (event) {
    case CommunicationEvent::kHeartbeatLost:
      return heartbeats_.any_lost();
    case CommunicationEvent::kLifeGuardingLost:
      return error_control_.lost();
    case CommunicationEvent::kBusOff:
      return bus_off_;
    default:
      return false;
  }
}

/// Only a failure of the communication changes the NMT state, no other error does (CiA 301 7.5.2.26).
void Device::communication_failed(CommunicationEvent event, nanoseconds now) {
  application_->communication(event, now);
  if (!nmt_.operational()) return;
  switch (static_cast<ErrorBehaviour>(error_behaviour_.value())) {
    case ErrorBehaviour::kNoChange:
      return;
    case ErrorBehaviour::kStopped:
      return enter(NmtState::kStopped, now);
    case ErrorBehaviour::kPreOperational:
      return enter(NmtState::kPreOperational, now);
  }
}

void Device::monitored(HeartbeatConsumer::Event event, nanoseconds now) {
  switch (event) {
    case HeartbeatConsumer::Event::kLost:
      raise_failure(canopen::emergency_code::kErrorControl, kStackSource, now);
      return communication_failed(CommunicationEvent::kHeartbeatLost, now);
    case HeartbeatConsumer::Event::kBack:
      if (!heartbeats_.any_lost()) {
        emergency_.clear(canopen::emergency_code::kErrorControl, kStackSource, tells_errors(), now);
      }
      return application_->communication(CommunicationEvent::kHeartbeatBack, now);
    case HeartbeatConsumer::Event::kBootUp:
      return application_->communication(CommunicationEvent::kMonitoredNodeBoot, now);
    case HeartbeatConsumer::Event::kNone:
      return;
  }
}

void Device::guarded(ErrorControlService::Event event, nanoseconds now) {
  if (event == ErrorControlService::Event::kLost) {
    raise_failure(canopen::emergency_code::kErrorControl, kGuardingSource, now);
    communication_failed(CommunicationEvent::kLifeGuardingLost, now);
  } else if (event == ErrorControlService::Event::kBack) {
    emergency_.clear(canopen::emergency_code::kErrorControl, kGuardingSource, tells_errors(), now);
    application_->communication(CommunicationEvent::kLifeGuardingBack, now);
  }
}

void Device::error_state_changed(can::ErrorState state, nanoseconds now) {
  now_ = now;
  if (node_id_ == 0) {
    bus_off_ = state == can::ErrorState::kBusOff;
    return;
  }
  switch (state) {
    case can::ErrorState::kBusOff:
      bus_off_ = announced_ = true;  // what waited is lost
      nmt_queue_.clear();            // a start from before would be obeyed behind the failure
      return communication_failed(CommunicationEvent::kBusOff, now);
    case can::ErrorState::kPassive:
      return raise_stack_error(canopen::emergency_code::kErrorPassive, kStackSource, now);
    case can::ErrorState::kActive:
      break;
  }
  emergency_.clear(canopen::emergency_code::kErrorPassive, kStackSource, tells_errors(), now);
  if (!std::exchange(bus_off_, false)) return;
  // While it was bus off nothing could be sent: the message says that it was.
  raise_failure(canopen::emergency_code::kRecoveredFromBusOff, kStackSource, now);
  emergency_.clear(canopen::emergency_code::kRecoveredFromBusOff, kStackSource, tells_errors(), now);
  application_->communication(CommunicationEvent::kBusRecovered, now);
}

void Device::advance(nanoseconds now) {
  now_ = now;
  if (pending_) reset(*pending_, now);
  if (application_->next_wake() <= now) application_->advance(now);
  if (boot_up_at_ <= now) boot_up(now);
  if (obey_at_ <= now) obey_nmt(now);
  if (node_id_ == 0) return;
  outbox_.advance(now);
  guarded(error_control_.advance(nmt_.state(), now), now);
  for (auto event = heartbeats_.advance(now); event != HeartbeatConsumer::Event::kNone;
       event = heartbeats_.advance(now)) {
    monitored(event, now);
  }
  if (nmt_.configurable()) {
    if (const auto message = sync_.advance(now)) sync(*message, now);
  }
  emergency_.advance(tells_errors(), now);
  pdos_.advance(now);
}

/// Called for every node at every event of the bus. std::min of a list would put the times into memory first.
nanoseconds Device::next_wake() const noexcept {
  if (pending_) return nanoseconds{0};
  nanoseconds next = std::min(boot_up_at_, obey_at_);
  next = std::min(next, application_->next_wake());
  if (node_id_ == 0) return next;
  next = std::min(next, outbox_.next_wake());
  next = std::min(next, error_control_.next_wake());
  next = std::min(next, heartbeats_.next_wake());
  next = std::min(next, emergency_.next_wake(tells_errors()));
  if (nmt_.configurable()) next = std::min(next, sync_.next_wake());
  return std::min(next, pdos_.next_wake());
}

}  // namespace driveline::slaves::cia301
