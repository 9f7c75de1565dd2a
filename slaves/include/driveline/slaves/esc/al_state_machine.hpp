#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/esc.hpp"
#include "driveline/slaves/esc/sync_supervision.hpp"

namespace driveline::slaves {

/// Times of the AL state machine of an emulated slave.
struct AlOptions {
  std::chrono::nanoseconds transition_delay{0};  ///< from a request to its execution
  /// How long SAFEOP to OP waits for valid outputs. Shorter than the time-outs of the usual masters (2 s and up), so
  /// that these get the AL status code.
  std::chrono::nanoseconds safeop_to_op_timeout = std::chrono::seconds{1};
  /// Explicit device identification, as a switch on the device sets it; 0: that of the device's profile.
  std::uint16_t device_id = 0;
};

/// The EtherCAT state machine of a slave (ETG.1000.6 chapter 6): answers AL control requests, checks what the master
/// has configured, locks and releases the sync managers, reports errors with their AL status code until they are
/// acknowledged. A request without acknowledge is ignored while an error is pending, unless it asks for INIT.
///
/// All functions but the constructor are \rtsafe as far as the device's are.
class AlStateMachine {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Stands for "nothing pending" in due().
  static constexpr Nanoseconds kNever = Nanoseconds::max();

  /// Starts as after reset(). Controller and device must outlive it.
  AlStateMachine(Esc& esc, Device& device, const AlOptions& options) noexcept;

  /// After power-on of the controller: INIT, sync managers locked.
  void reset() noexcept;
  /// Looks at what the master has written: AL control, sync manager activation.
  void handle_events(Nanoseconds now) noexcept;
  /// Time of the next call of on_time(); kNever when nothing is pending.
  [[nodiscard]] Nanoseconds due() const noexcept {
    return std::min(pending_ ? pending_->due : kNever, synchronisation_.due());
  }
  /// A delay or time-out has passed, or a SYNC0 has not come.
  void on_time(Nanoseconds now) noexcept;
  /// SYNC0 or SYNC1 came, at `time`.
  void on_sync(SyncSignal signal, Nanoseconds time) noexcept;
  /// How long before the SYNC pulses outputs have arrived since OP was entered.
  [[nodiscard]] const SyncMargin& sync_margin() const noexcept { return synchronisation_.margin(); }
  /// A regular step has passed: checks for outputs or SYNC0 where a transition waits for them.
  void on_step(Nanoseconds now) noexcept;
  /// The slave leaves its state by itself and reports why.
  void fall_back(wire::AlState to, wire::AlStatusCode reason) noexcept;

  /// The state the slave is in, not the one asked for.
  [[nodiscard]] wire::AlState state() const noexcept { return state_; }
  /// An error is reported (AL status bit 4) and not acknowledged yet.
  [[nodiscard]] bool error() const noexcept { return error_; }
  /// Mailboxes are served.
  [[nodiscard]] bool mailbox_running() const noexcept {
    return state_ != wire::AlState::kInit && state_ != wire::AlState::kNone;
  }
  /// Inputs are published.
  [[nodiscard]] bool inputs_running() const noexcept {
    return state_ == wire::AlState::kSafeOp || state_ == wire::AlState::kOp;
  }
  /// Outputs reach the application.
  [[nodiscard]] bool outputs_running() const noexcept { return state_ == wire::AlState::kOp; }

  /// \name Faults
  /// @{

  /// From a request to its execution, as for AlOptions.
  [[nodiscard]] Nanoseconds transition_delay() const noexcept { return options_.transition_delay; }
  /// From the next request on; a pending one keeps its time.
  void set_transition_delay(Nanoseconds delay) noexcept { options_.transition_delay = delay; }
  /// Every transition to `to` is refused with `code` until clear_refusal().
  void refuse(wire::AlState to, wire::AlStatusCode code) noexcept { refusal_ = Refusal{to, code}; }
  /// Ends refuse().
  void clear_refusal() noexcept { refusal_.reset(); }
  /// @}

 private:
  struct Pending {
    wire::AlState target;
    Nanoseconds due;
    bool waits = false;  ///< for outputs or synchronisation; else for its time
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
  void give_up_waiting() noexcept;
  [[nodiscard]] bool ready_for_op() const noexcept;
  void react_to_synchronisation() noexcept;
  [[nodiscard]] std::uint32_t outputs_written() const noexcept;
  [[nodiscard]] Nanoseconds last_outputs() const noexcept;
  void enter(wire::AlState target) noexcept;
  void report(wire::AlStatusCode code) noexcept;
  [[nodiscard]] std::uint16_t device_id() const noexcept;
  void publish() noexcept;
  [[nodiscard]] wire::AlStatusCode check_legal(wire::AlState target) const noexcept;
  [[nodiscard]] wire::AlStatusCode check_settings(wire::AlState target) const noexcept;
  [[nodiscard]] bool outputs_expected() const noexcept;
  [[nodiscard]] bool outputs_valid() const noexcept;
  [[nodiscard]] bool outputs_received() const noexcept;
  void lock_sync_managers(bool mailboxes, bool process_data) noexcept;

  Esc& esc_;
  Device& device_;
  AlOptions options_;
  SyncSupervision synchronisation_;
  wire::AlState state_ = wire::AlState::kInit;
  bool error_ = false;
  bool id_loaded_ = false;
  wire::AlStatusCode code_ = wire::AlStatusCode::kNoError;
  std::optional<Pending> pending_;
  std::optional<Refusal> refusal_;
};

}  // namespace driveline::slaves
