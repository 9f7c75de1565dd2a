#pragma once

#include "driveline/slaves/od/entry_row.hpp"
#include "driveline/wire/al.hpp"

namespace driveline::slaves {

/// Converts an AL state to an access phase: mailbox access is possible in PREOP, SAFEOP and OP. \rtsafe
[[nodiscard]] constexpr AccessPhase access_phase(wire::AlState state) noexcept {
  switch (state) {
    case wire::AlState::kPreOp:
      return AccessPhase::kConfiguring;
    case wire::AlState::kSafeOp:
      return AccessPhase::kReady;
    case wire::AlState::kOp:
      return AccessPhase::kOperating;
    default:
      return AccessPhase::kClosed;
  }
}

/// Returns the access bits of a row as reported by SDO information (wire::entry_access). \rtsafe
[[nodiscard]] std::uint16_t coe_access(const EntryRow& row) noexcept;

}  // namespace driveline::slaves
