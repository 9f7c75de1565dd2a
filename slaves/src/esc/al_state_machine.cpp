#include "driveline/slaves/esc/al_state_machine.hpp"

#include <algorithm>

#include "driveline/slaves/esc/sync_manager_check.hpp"

namespace driveline::slaves {

using wire::AlState;
using wire::AlStatusCode;
using Use = SyncManagerLayout::Use;

AlStateMachine::AlStateMachine(Esc& esc, Device& device, const AlOptions& options) noexcept
    : esc_(esc), device_(device), options_(options), synchronisation_(esc.memory()) {
  reset();
}

void AlStateMachine::reset() noexcept {
  error_ = id_loaded_ = outputs_locked_ = inputs_locked_ = false;
  code_ = AlStatusCode::kNoError;
  pending_.reset();
  enter(AlState::kInit);
  publish();
}

void AlStateMachine::handle_events(Nanoseconds now) noexcept {
  if (const auto request = esc_.take_al_request()) {
    if (esc_.device_emulation()) {
      follow_control(request->control);
    } else {
      handle_request(*request, now);
    }
  }
  if (esc_.events().al_pending(al_event::kSyncManagerChanged)) {
    esc_.events().set_al(al_event::kSyncManagerChanged, false);
    if (!esc_.device_emulation()) check_configuration();
  }
}

void AlStateMachine::follow_control(wire::AlControl control) noexcept {
  // Without an application the controller copies AL control unchanged, including bit 4 (ESC data sheet I, device
  // emulation). Sync managers are never locked.
  state_ = control.state;
  esc_.set_al_status({control.state, control.acknowledge, control.request_id}, 0);
}

void AlStateMachine::handle_request(const Esc::AlRequest& request, Nanoseconds now) noexcept {
  const auto& control = request.control;
  if (error_ && !control.acknowledge && control.state != AlState::kInit) return;
  error_ = false;
  code_ = AlStatusCode::kNoError;
  id_loaded_ = control.request_id && answers_id_request();
  pending_.reset();
  if (const auto illegal = check_legal(control.state); illegal != AlStatusCode::kNoError)
    return refuse_request(illegal);
  if (outputs_locked_ || inputs_locked_) {
    outputs_locked_ = inputs_locked_ = false;
    lock_sync_managers();
  }
  if (control.state == state_) return publish();
  publish();
  pending_ = Pending{control.state, request.time + options_.transition_delay};
  run_pending(now);
}

AlStatusCode AlStateMachine::check_legal(AlState target) const noexcept {
  if (!wire::is_known(target)) return AlStatusCode::kUnknownRequestedState;
  if (target == state_ || target == AlState::kInit) return AlStatusCode::kNoError;
  // BOOT has no way but to INIT (ETG.1000.6; MSD manual 9.2, transitions IB and BI).
  const bool up = (state_ == AlState::kInit && (target == AlState::kPreOp || target == AlState::kBootstrap)) ||
                  (state_ == AlState::kPreOp && target == AlState::kSafeOp) ||
                  (state_ == AlState::kSafeOp && target == AlState::kOp);
  const bool down = (target == AlState::kPreOp && (state_ == AlState::kSafeOp || state_ == AlState::kOp)) ||
                    (target == AlState::kSafeOp && state_ == AlState::kOp);
  if (!up && !down) return AlStatusCode::kInvalidRequestedStateChange;
  const bool boot_supported = !device_.profile().bootstrap_mailboxes.empty();
  return target == AlState::kBootstrap && !boot_supported ? AlStatusCode::kBootstrapNotSupported
                                                          : AlStatusCode::kNoError;
}

void AlStateMachine::on_time(Nanoseconds now) noexcept {
  if (synchronisation_.due() <= now) {
    synchronisation_.on_time(now, outputs_written());
    react_to_synchronisation();
  }
  run_pending(now);
}

/// Executes the transition that is due. Apart from the supervision: a request is handled before the pulses that have
/// passed since the last frame are counted, and the supervision would find them missing.
void AlStateMachine::run_pending(Nanoseconds now) noexcept {
  if (!pending_ || pending_->due > now) return;
  return pending_->waits ? give_up_waiting() : execute(pending_->target, now);
}

void AlStateMachine::on_step(Nanoseconds now) noexcept {
  if (pending_ && pending_->waits && ready_for_op()) finish(pending_->target, now);
}

void AlStateMachine::on_sync(SyncSignal signal, Nanoseconds time) noexcept {
  synchronisation_.pulse(signal, time, outputs_written(), last_outputs());
  react_to_synchronisation();
}

void AlStateMachine::start_synchronisation() noexcept {
  synchronisation_.start(device_.sync_demand());
  device_.sync_started(synchronisation_.sync0_cycle());
}

void AlStateMachine::react_to_synchronisation() noexcept {
  const auto fault = synchronisation_.fault();
  if (outputs_running() && fault != AlStatusCode::kNoError) fall_back(AlState::kSafeOp, fault);
}

bool AlStateMachine::ready_for_op() const noexcept {
  return (!outputs_expected() || outputs_valid()) && synchronisation_.obstacle() == AlStatusCode::kNoError;
}

void AlStateMachine::give_up_waiting() noexcept {
  pending_.reset();
  // Without SYNC0, the timing of the outputs cannot be checked.
  if (const auto obstacle = synchronisation_.obstacle(); obstacle != AlStatusCode::kNoError) return report(obstacle);
  report(esc_.watchdog().expired() ? AlStatusCode::kSyncManagerWatchdog : AlStatusCode::kNoValidOutputs);
}

void AlStateMachine::execute(AlState target, Nanoseconds now) noexcept {
  pending_.reset();
  if (refusal_ && refusal_->to == target) return report(refusal_->code);
  if (const auto code = check_settings(target); code != AlStatusCode::kNoError) return report(code);
  if (target == AlState::kOp) {
    start_synchronisation();
    if (!ready_for_op()) {
      pending_ = Pending{target, now + options_.safeop_to_op_timeout, true};
      return;
    }
  }
  finish(target, now);
}

void AlStateMachine::finish(AlState target, Nanoseconds now) noexcept {
  pending_.reset();
  if (const auto code = device_.transition(state_, target); code != AlStatusCode::kNoError) return report(code);
  enter(target);
  if (target == AlState::kOp) synchronisation_.enter_op(now, outputs_written());
  publish();
}

AlStatusCode AlStateMachine::check_settings(AlState target) const noexcept {
  const auto& profile = device_.profile();
  if (target == AlState::kBootstrap) {
    return check_mailboxes(esc_, profile.bootstrap_mailboxes, AlStatusCode::kInvalidMailboxConfigurationBoot);
  }
  const bool up = target > state_;
  if (!up) return AlStatusCode::kNoError;
  if (state_ == AlState::kInit && !device_.firmware_valid()) return AlStatusCode::kNoValidFirmware;
  if (state_ == AlState::kPreOp) {
    if (const auto mapping = device_.check_mapping(); mapping != AlStatusCode::kNoError) return mapping;
  }
  auto code = check_mailboxes(esc_, profile.sync_managers, AlStatusCode::kInvalidMailboxConfigurationPreOp);
  if (code == AlStatusCode::kNoError && target != AlState::kPreOp) code = check_process_data(esc_, device_);
  if (code == AlStatusCode::kNoError && target != AlState::kPreOp) code = check_watchdog(esc_, device_);
  if (state_ != AlState::kPreOp || code != AlStatusCode::kNoError) return code;
  code = synchronisation_.check(device_.sync_demand());
  if (code == AlStatusCode::kNoError && !device_.inputs_valid()) code = AlStatusCode::kNoValidInputs;
  return code;
}

void AlStateMachine::check_configuration() noexcept {
  if (!mailbox_running()) return;
  const auto& profile = device_.profile();
  const bool boot = state_ == AlState::kBootstrap;
  const auto mailboxes =
      boot ? check_mailboxes(esc_, profile.bootstrap_mailboxes, AlStatusCode::kInvalidMailboxConfigurationBoot)
           : check_mailboxes(esc_, profile.sync_managers, AlStatusCode::kInvalidMailboxConfigurationPreOp);
  if (mailboxes != AlStatusCode::kNoError) return fall_back(AlState::kInit, mailboxes);
  if (!inputs_running()) return;
  const auto process_data = check_process_data(esc_, device_);
  if (process_data != AlStatusCode::kNoError) fall_back(AlState::kPreOp, process_data);
}

/// The table of ETG.1000.6 (AL status codes) keeps the state after 0x0011 and 0x0012, and vendors repeat it. Slave
/// stacks go from OP to SAFEOP: KickCAT (ESMStates), made to match the conformance test TF-1200 in its pull request
/// 181, Beckhoff's Slave Stack Code 5.11 (AL_ControlInd), and SOES (ESC_state).
void AlStateMachine::refuse_request(AlStatusCode code) noexcept {
  if (state_ == AlState::kOp) return fall_back(AlState::kSafeOp, code);
  report(code);
}

/// A slave that leaves OP for SAFEOP with an error disables its output sync manager until the error is acknowledged,
/// and its input sync manager only if the inputs are invalid, as after an error of the synchronisation (ETG.1000.6,
/// error indication, as cited in KickCAT issue 139). A slave with outputs keeps its inputs, as the Slave Stack Code
/// does: the missing outputs show in the working counter.
void AlStateMachine::fall_back(AlState to, AlStatusCode reason) noexcept {
  const auto from = state_;
  pending_.reset();
  if (from == AlState::kOp && to == AlState::kSafeOp) {
    outputs_locked_ = true;
    inputs_locked_ = !outputs_expected() && is_sync_error(reason);
  }
  enter(to);
  report(reason);
  device_.fall_back(from, to, reason);
}

void AlStateMachine::enter(AlState target) noexcept {
  const auto from = state_;
  state_ = target;
  if (target == AlState::kSafeOp && from == AlState::kPreOp) start_synchronisation();
  if (target == AlState::kSafeOp && from == AlState::kOp) synchronisation_.leave_op();
  if (!inputs_running()) synchronisation_.stop();
  if (!esc_.device_emulation()) lock_sync_managers();
}

bool AlStateMachine::locked(Use use) const noexcept {
  switch (use) {
    case Use::kMailboxOut:
    case Use::kMailboxIn:
      return !mailbox_running();
    case Use::kOutputs:
      return !inputs_running() || outputs_locked_;
    case Use::kInputs:
      return !inputs_running() || inputs_locked_;
  }
  return true;
}

void AlStateMachine::lock_sync_managers() noexcept {
  auto& unit = esc_.sync_managers();
  const auto& layout = device_.profile().sync_managers;
  const auto count = std::min<std::size_t>(layout.size(), unit.count());
  for (unsigned n = 0; n < count; ++n) unit.set_deactivated(n, locked(layout[n].use));
}

bool AlStateMachine::outputs_expected() const noexcept {
  const auto& layout = device_.profile().sync_managers;
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use == Use::kOutputs && device_.process_data_size(n) > 0) return true;
  }
  return false;
}

std::uint32_t AlStateMachine::outputs_written() const noexcept {
  const auto& layout = device_.profile().sync_managers;
  std::uint32_t count = 0;
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use == Use::kOutputs && n < esc_.sync_managers().count())
      count += esc_.sync_managers().write_count(n);
  }
  return count;
}

AlStateMachine::Nanoseconds AlStateMachine::last_outputs() const noexcept {
  const auto& layout = device_.profile().sync_managers;
  Nanoseconds last{0};
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use == Use::kOutputs && n < esc_.sync_managers().count())
      last = std::max(last, esc_.sync_managers().last_write(n));
  }
  return last;
}

bool AlStateMachine::outputs_received() const noexcept {
  const auto& layout = device_.profile().sync_managers;
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (layout[n].use != Use::kOutputs || device_.process_data_size(n) == 0) continue;
    if (esc_.sync_managers().write_count(n) == 0) return false;
  }
  return true;
}

bool AlStateMachine::outputs_valid() const noexcept {
  return outputs_received() && !esc_.watchdog().expired();
}

void AlStateMachine::report(AlStatusCode code) noexcept {
  error_ = true;
  id_loaded_ = false;
  code_ = code;
  publish();
}

/// A device that announces the identification (SII, ETG.1000.6 Table 22) answers with 0 when no ID is set; one that
/// does not leaves bit 5 of AL status at 0, which masters wait for in vain (ETG.1020, explicit device identification).
/// So do Beckhoff's Slave Stack Code (EXPLICIT_DEVICE_ID, SetALStatus) and SOES (pull request 116, no hook).
bool AlStateMachine::answers_id_request() const noexcept {
  return device_id() != 0 || device_.profile().identification;
}

std::uint16_t AlStateMachine::device_id() const noexcept {
  return options_.device_id != 0 ? options_.device_id : device_.profile().device_id;
}

void AlStateMachine::publish() noexcept {
  // There is no identification in BOOT (Slave Stack Code 5.11, SetALStatus).
  const bool shows_id = id_loaded_ && state_ != AlState::kBootstrap;
  const auto code = shows_id ? device_id() : static_cast<std::uint16_t>(code_);
  esc_.set_al_status({state_, error_, shows_id}, code);
}

}  // namespace driveline::slaves
