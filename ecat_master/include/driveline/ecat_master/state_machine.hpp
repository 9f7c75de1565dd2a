#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// AL status of one slave, read in one go.
struct AlReport {
  wire::AlStatus status;                                   ///< state and error flag
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< meaning depends on the error flag
};

/// Time a slave has for one transition unless told otherwise (ETG.1020: 3 s to PREOP, 10 s to SAFEOP and OP).
inline constexpr std::chrono::seconds kPreOpTimeout{3};
/// See kPreOpTimeout; for SAFEOP and for OP.
inline constexpr std::chrono::seconds kOpTimeout{10};

/// How long a slave may take for its transitions. Defaults: kPreOpTimeout, kOpTimeout for SAFEOP and OP, 5 s back to
/// INIT, 200 ms back to SAFEOP.
struct StateTimeouts {
  using Limit = std::optional<std::chrono::nanoseconds>;  ///< none: the default
  Limit to_pre_op;                                        ///< also to BOOT
  Limit to_safe_op;                                       ///< from PREOP
  Limit to_op;                                            ///< from SAFEOP
  Limit back_to_init;                                     ///< from any state
  Limit back_to_safe_op;                                  ///< from OP
  constexpr bool operator==(const StateTimeouts&) const = default;
  /// The limit for going to `target`, from above when `down`.
  [[nodiscard]] std::chrono::nanoseconds limit(wire::AlState target, bool down) const noexcept;
};

/// One slave of a change of state.
struct StateTarget {
  SlaveRef slave;                       ///< whom
  std::chrono::nanoseconds timeout{0};  ///< how long it may take
};

/// AL status of all `slaves`, in their order. Errors: WorkingCounter for a slave that does not answer, those of the
/// bus.
[[nodiscard]] Result<std::vector<AlReport>> read_al_status(Bus& bus, std::span<const SlaveRef> slaves);

/// AL status of everything on the line by position, for slaves without station addresses. Errors: NoSlaves,
/// WorkingCounter, those of the bus.
[[nodiscard]] Result<std::vector<AlReport>> peek_states(Bus& bus);

/// Requests `target` from all `slaves` at once, acknowledging errors first, and waits for each of them until its own
/// time limit, independently of the others. One result per slave: StateRefused with the AL status code, StateTimeout,
/// WorkingCounter for a slave that does not answer several times in a row, or the error of the bus.
[[nodiscard]] std::vector<Result<void>> change_states(Bus& bus, std::span<const StateTarget> slaves,
                                                      wire::AlState target);

/// The first refusal, or else the first other failure, or success.
[[nodiscard]] Result<void> first_failure(std::span<const Result<void>> results);

/// change_states() with one time limit for all. Returns the error of the first slave that refused, or else of the first
/// that failed otherwise. The slaves that made it stay where they are; the call may be repeated.
[[nodiscard]] Result<void> change_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                                        std::chrono::nanoseconds timeout);

/// Takes those of `slaves` that are above `target` down to it; the others stay where they are. A slave that does not
/// answer or refuses does not keep the rest from going; the first error is returned.
[[nodiscard]] Result<void> lower_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                                       std::chrono::nanoseconds timeout);

}  // namespace driveline::ecat_master
