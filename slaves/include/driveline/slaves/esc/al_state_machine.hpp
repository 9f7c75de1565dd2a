#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/esc.hpp"
#include "driveline/slaves/esc/sync_supervision.hpp"

namespace driveline::slaves {

/// Times and identification of an emulated slave's AL state machine.
struct AlOptions {
  std::chrono::nanoseconds transition_delay{0};  ///< from a request to its execution
  /// How long SAFEOP to OP waits for valid outputs. Shorter than the time-outs of the usual masters (2 s and up), so
  /// that they receive the AL status code.
  std::chrono::nanoseconds safeop_to_op_timeout = std::chrono::seconds{1};
  /// Explicit device identification, as set by a switch on the device; 0: value of the device's profile.
  std::uint16_t device_id = 0;
};

/// The EtherCAT state machine of a slave (ETG.1000.6 chapter 6): answers AL control requests, checks the master's
/// configuration, locks and releases the sync managers, and reports errors with their AL status code until they are
/// acknowledged. A request without acknowledge is ignored while an error is pending, unless it requests INIT.
///
/// An error takes the slave out of OP, also a request for a state that is illegal or unknown; its outputs are then
/// locked until the error is acknowledged (docs/slave_controller.md).
///
/// All functions except the constructor are \rtsafe if the functions of the device are.
class AlStateMachine {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Value of due() when nothing is pending.
  static constexpr Nanoseconds kNever = Nanoseconds::max();

  /// Starts in the state of reset(). Controller and device must outlive it.
  AlStateMachine(Esc& esc, Device& device, const AlOptions& options) noexcept;

  /// Resets to the state after power-on of the controller: INIT, sync managers locked.
  void reset() noexcept;
  /// Handles writes of the master to AL control and to sync manager activation.
  void handle_events(Nanoseconds now) noexcept;
  /// Returns the time of the next call of on_time(); kNever when nothing is pending.
  [[nodiscard]] Nanoseconds due() const noexcept {
    return std::min(pending_ ? pending_->due : kNever, synchronisation_.due());
  }
  /// Handles an expired delay or time-out, or a missing SYNC0.
  void on_time(Nanoseconds now) noexcept;
  /// Called for each SYNC0 or SYNC1, at `time`.
  void on_sync(SyncSignal signal, Nanoseconds time) noexcept;
  /// Called instead of on_sync() while the application is busy and cannot serve the pulse.
  void on_unserved_sync(SyncSignal signal, Nanoseconds time) noexcept { synchronisation_.unserved(signal, time); }
  /// Returns how long before the SYNC pulses the outputs have arrived since OP was entered.
  [[nodiscard]] const SyncMargin& sync_margin() const noexcept { return synchronisation_.margin(); }
  /// Called after each regular step: checks for outputs or SYNC0 when a transition waits for them.
  void on_step(Nanoseconds now) noexcept;
  /// Leaves the state without a request of the master, and reports the reason.
  void fall_back(wire::AlState to, wire::AlStatusCode reason) noexcept;

  /// Returns the current state, not the requested one.
  [[nodiscard]] wire::AlState state() const noexcept { return state_; }
  /// Whether an error is reported (AL status bit 4) and not yet acknowledged.
  [[nodiscard]] bool error() const noexcept { return error_; }
  /// Whether mailboxes are served.
  [[nodiscard]] bool mailbox_running() const noexcept {
    return state_ != wire::AlState::kInit && state_ != wire::AlState::kNone;
  }
  /// Whether inputs are published.
  [[nodiscard]] bool inputs_running() const noexcept {
    return state_ == wire::AlState::kSafeOp || state_ == wire::AlState::kOp;
  }
  /// Whether outputs are transferred to the application.
  [[nodiscard]] bool outputs_running() const noexcept { return state_ == wire::AlState::kOp; }

  /// \name Faults
  /// @{

  /// Returns the time from a request to its execution, see AlOptions.
  [[nodiscard]] Nanoseconds transition_delay() const noexcept { return options_.transition_delay; }
  /// Sets the delay of further requests; a pending request keeps its time.
  void set_transition_delay(Nanoseconds delay) noexcept { options_.transition_delay = delay; }
  /// Refuses every transition to `to` with `code` until clear_refusal().
  void refuse(wire::AlState to, wire::AlStatusCode code) noexcept { refusal_ = Refusal{to, code}; }
  /// Cancels refuse().
  void clear_refusal() noexcept { refusal_.reset(); }
  /// @}

 private:
  struct Pending {
    wire::AlState target;
    Nanoseconds due;
    bool waits = false;  ///< waits for outputs or synchronisation until `due`
  };
  struct Refusal {
    wire::AlState to;
    wire::AlStatusCode code;
  };

  void handle_request(const Esc::AlRequest& request, Nanoseconds now) noexcept;
  void follow_control(wire::AlControl control) noexcept;
  void check_configuration() noexcept;
  void execute(wire::AlState target, Nanoseconds now) noexcept;
  void finish(wire::AlState target, Nanoseconds now) noexcept;
  void run_pending(Nanoseconds now) noexcept;
  void give_up_waiting() noexcept;
  [[nodiscard]] bool ready_for_op() const noexcept;
  void start_synchronisation() noexcept;
  void react_to_synchronisation() noexcept;
  [[nodiscard]] std::uint32_t outputs_written() const noexcept;
  [[nodiscard]] Nanoseconds last_outputs() const noexcept;
  void enter(wire::AlState target) noexcept;
  void refuse_request(wire::AlStatusCode code) noexcept;
  void report(wire::AlStatusCode code) noexcept;
  [[nodiscard]] bool answers_id_request() const noexcept;
  [[nodiscard]] std::uint16_t device_id() const noexcept;
  void publish() noexcept;
  [[nodiscard]] wire::AlStatusCode check_legal(wire::AlState target) const noexcept;
  [[nodiscard]] wire::AlStatusCode check_settings(wire::AlState target) const noexcept;
  [[nodiscard]] bool outputs_expected() const noexcept;
  [[nodiscard]] bool outputs_valid() const noexcept;
  [[nodiscard]] bool outputs_received() const noexcept;
  [[nodiscard]] bool locked(SyncManagerLayout::Use use) const noexcept;
  void lock_sync_managers() noexcept;

  Esc& esc_;
  Device& device_;
  AlOptions options_;
  SyncSupervision synchronisation_;
  wire::AlState state_ = wire::AlState::kInit;
  bool error_ = false;
  bool id_loaded_ = false;
  bool outputs_locked_ = false;  ///< OP was left by an error that is not acknowledged yet
  bool inputs_locked_ = false;   ///< the same, and the error makes the inputs of a slave without outputs invalid
  wire::AlStatusCode code_ = wire::AlStatusCode::kNoError;
  std::optional<Pending> pending_;
  std::optional<Refusal> refusal_;
};

}  // namespace driveline::slaves
