#pragma once

#include <chrono>
#include <vector>

#include "driveline/ecat_master/bus.hpp"

namespace driveline::ecat_master {

/// AL status of one slave, read in one go.
struct AlReport {
  wire::AlStatus status;
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;
};

/// Time a slave has for one transition unless told otherwise (ETG.1020: 3 s to PREOP, 10 s to SAFEOP and OP).
inline constexpr std::chrono::seconds kPreOpTimeout{3};
inline constexpr std::chrono::seconds kOpTimeout{10};

/// AL status of all `slaves`, in their order. Errors: kWorkingCounter for a slave that does not answer, those of the
/// bus.
[[nodiscard]] Result<std::vector<AlReport>> read_al_status(Bus& bus, std::span<const SlaveRef> slaves);

/// AL status of everything on the line by position, for slaves without station addresses. Errors: kNoSlaves,
/// kWorkingCounter, those of the bus.
[[nodiscard]] Result<std::vector<AlReport>> peek_states(Bus& bus);

/// Asks all `slaves` for `target` at once, acknowledging errors where there are any, and waits until all are there.
/// Returns the first slave that refused (kStateRefused with its AL status code) or was late (kStateTimeout). The
/// slaves that made it stay where they are; the call may be repeated.
[[nodiscard]] Result<void> change_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                                        std::chrono::nanoseconds timeout);

/// Takes those of `slaves` that are above `target` down to it; the others stay where they are. A slave that does not
/// answer or refuses does not keep the rest from going; the first error is returned.
[[nodiscard]] Result<void> lower_state(Bus& bus, std::span<const SlaveRef> slaves, wire::AlState target,
                                       std::chrono::nanoseconds timeout);

}  // namespace driveline::ecat_master
