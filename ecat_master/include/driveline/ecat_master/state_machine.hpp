#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/error/startup_note.hpp"

namespace driveline::ecat_master {

/// AL status of a slave, read in a single datagram.
struct AlReport {
  wire::AlStatus status;                                   ///< state and error flag
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< meaning depends on the error flag
};

/// Default time-out of a transition (ETG.1020: 3 s to PREOP, 10 s to SAFEOP and OP).
inline constexpr std::chrono::seconds kPreOpTimeout{3};
/// See kPreOpTimeout; for transitions to SAFEOP and OP.
inline constexpr std::chrono::seconds kOpTimeout{10};
/// Default time-out of a slave with an SoE mailbox to SAFEOP and OP: its drives check all their parameters in these
/// transitions (S-0-0127 and S-0-0128).
inline constexpr std::chrono::seconds kSoeOpTimeout{20};

/// Pause before a refused state is requested again. Drives that refuse their first SAFEOP reach it a moment later.
inline constexpr std::chrono::milliseconds kStateRetryPause{100};

/// Time-outs of a slave's transitions. Defaults: kPreOpTimeout, kOpTimeout for SAFEOP and OP, 5 s back to INIT, 200 ms
/// back to SAFEOP.
struct StateTimeouts {
  using Limit = std::optional<std::chrono::nanoseconds>;  ///< empty: the default
  Limit to_pre_op;                                        ///< also to BOOT
  Limit to_safe_op;                                       ///< from PREOP
  Limit to_op;                                            ///< from SAFEOP
  Limit back_to_init;                                     ///< from any state
  Limit back_to_safe_op;                                  ///< from OP
  constexpr bool operator==(const StateTimeouts&) const = default;
  /// The limit for the transition to `target`; `down`: from a higher state.
  [[nodiscard]] std::chrono::nanoseconds limit(wire::AlState target, bool down) const noexcept;
};

/// Repeated requests for a state that a slave refuses for a reason that may pass.
struct StateRetries {
  unsigned count = 2;                                 ///< requests after the first refusal
  std::chrono::nanoseconds pause = kStateRetryPause;  ///< time between a refusal and the next request
  constexpr bool operator==(const StateRetries&) const = default;
};

/// Whether a refusal may pass by itself: the slave was not ready, or its application had not yet applied what was
/// written to it. False for what only another configuration, firmware or state changes. docs/real_drives.md lists the
/// codes.
[[nodiscard]] bool may_pass(wire::AlStatusCode code) noexcept;

/// A slave in a change of state.
struct StateTarget {
  SlaveRef slave;                       ///< the slave
  std::chrono::nanoseconds timeout{0};  ///< time-out of its transition, for each request
  StateRetries retries{0};              ///< repeated requests after refusals that may_pass()
};

/// Reads the AL status of all `slaves`, in their order. Errors: WorkingCounter for a slave that does not answer, those
/// of the bus.
[[nodiscard]] Result<std::vector<AlReport>> read_al_status(Bus& bus, std::span<const SlaveRef> slaves);

/// Reads the AL status of all slaves on the line by position, for slaves without station addresses. Errors: NoSlaves,
/// WorkingCounter, those of the bus.
[[nodiscard]] Result<std::vector<AlReport>> peek_states(Bus& bus);

/// Requests `target` from all `slaves` at once, acknowledging errors first, and waits for each of them until its time
/// limit, independently of the others. A slave that refuses with AL status code 0x0050, because its application cannot
/// read its EEPROM, gets the EEPROM interface and is asked once more. One result per slave: StateRefused with the AL
/// status code of the last refusal, StateTimeout, WorkingCounter for a slave that does not answer several times in a
/// row, or the error of the bus. A slave that reached the state after refusals (StateTarget::retries) is added to
/// `notes`; null: to none.
[[nodiscard]] std::vector<Result<void>> change_states(Bus& bus, std::span<const StateTarget> slaves,
                                                      wire::AlState target, StartupNotes* notes = nullptr);

/// The first refusal, else the first other failure, else success.
[[nodiscard]] Result<void> first_failure(std::span<const Result<void>> results);

/// change_states() with one time limit for all. Returns the error of the first slave that refused, or else of the first
/// slave that failed otherwise. Successful slaves stay in the new state; the call may be repeated.
[[nodiscard]] Result<void> change_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                                        std::chrono::nanoseconds timeout);

/// Takes those of `slaves` that are above `target` down to it; the others do not change. A slave that does not answer
/// or refuses does not stop the others; the first error is returned.
[[nodiscard]] Result<void> lower_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                                       std::chrono::nanoseconds timeout);

}  // namespace driveline::ecat_master
