#pragma once

#include <cstdint>
#include <string_view>

#include "driveline/bytes/endian.hpp"

namespace driveline::wire {

/// States of the EtherCAT state machine as coded in AL control and AL status (ETG.1000.6 5.3.1). Other values may
/// arrive from the wire and are retained.
enum class AlState : std::uint8_t {
  kNone = 0,
  kInit = 1,
  kPreOp = 2,
  kBootstrap = 3,
  kSafeOp = 4,
  kOp = 8,
};

/// True for the five states that the standard names; registers may hold anything. \rtsafe
[[nodiscard]] constexpr bool is_known(AlState state) noexcept {
  return state == AlState::kInit || state == AlState::kPreOp || state == AlState::kBootstrap ||
         state == AlState::kSafeOp || state == AlState::kOp;
}

/// Name as users of EtherCAT tools know it; "?" for an unknown code.
[[nodiscard]] constexpr std::string_view to_text(AlState state) noexcept {
  switch (state) {
    case AlState::kNone:
      return "NONE";
    case AlState::kInit:
      return "INIT";
    case AlState::kPreOp:
      return "PREOP";
    case AlState::kBootstrap:
      return "BOOT";
    case AlState::kSafeOp:
      return "SAFEOP";
    case AlState::kOp:
      return "OP";
  }
  return "?";
}

/// AL control register 0x0120 (ETG.1000.6 Table 9): requested state, error acknowledge, request for the device
/// identification value.
struct AlControl {
  AlState state = AlState::kInit;  ///< requested state
  bool acknowledge = false;        ///< bit 4: acknowledges the error that the slave reports
  bool request_id = false;         ///< bit 5: requests the explicit device identification (ETG.1020)

  /// The value of register 0x0120. \rtsafe
  [[nodiscard]] constexpr std::uint16_t raw() const noexcept {
    return static_cast<std::uint16_t>((static_cast<unsigned>(state) & 0x0FU) | (acknowledge ? 0x10U : 0U) |
                                      (request_id ? 0x20U : 0U));
  }
  /// Decodes register 0x0120; drops reserved bits. \rtsafe
  [[nodiscard]] static constexpr AlControl from_raw(std::uint16_t raw) noexcept {
    return {static_cast<AlState>(raw & 0x0F), (raw & 0x10) != 0, (raw & 0x20) != 0};
  }
  constexpr bool operator==(const AlControl&) const = default;
};

/// AL status register 0x0130 (ETG.1000.6 Table 10): actual state, error indication, identification value loaded.
struct AlStatus {
  AlState state = AlState::kInit;  ///< current state of the slave
  bool error = false;              ///< bit 4: the last state change failed; the AL status code tells why
  bool id_loaded = false;          ///< bit 5: the AL status code register holds the device identification

  /// The value of register 0x0130. \rtsafe
  [[nodiscard]] constexpr std::uint16_t raw() const noexcept {
    return static_cast<std::uint16_t>((static_cast<unsigned>(state) & 0x0FU) | (error ? 0x10U : 0U) |
                                      (id_loaded ? 0x20U : 0U));
  }
  /// Decodes register 0x0130; drops reserved bits. \rtsafe
  [[nodiscard]] static constexpr AlStatus from_raw(std::uint16_t raw) noexcept {
    return {static_cast<AlState>(raw & 0x0F), (raw & 0x10) != 0, (raw & 0x20) != 0};
  }
  constexpr bool operator==(const AlStatus&) const = default;
};

}  // namespace driveline::wire
