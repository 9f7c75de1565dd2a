#pragma once

#include <array>
#include <cstdint>

namespace driveline::wire {

/// Loop setting of a port in DL control 0x0100, bits 8-15 (ETG.1000.4 Table 37).
enum class LoopControl : std::uint8_t { kAuto = 0, kAutoClose = 1, kOpen = 2, kClosed = 3 };

/// DL status register 0x0110 (ETG.1000.4 Table 39): PDI state and, per port, physical link, loop and communication.
struct DlStatus {
  /// One port of the slave controller.
  struct Port {
    bool link = false;           ///< physical link detected
    bool loop_closed = true;     ///< frames return at this port
    bool communication = false;  ///< stable communication established
    constexpr bool operator==(const Port&) const = default;
  };
  bool pdi_operational = false;          ///< bit 0: EEPROM loaded, the application has access
  bool pdi_watchdog_ok = false;          ///< bit 1: the application's watchdog has not expired
  bool enhanced_link_detection = false;  ///< bit 2
  std::array<Port, 4> ports{};           ///< indexed by port number

  /// The value of register 0x0110. \rtsafe
  [[nodiscard]] constexpr std::uint16_t raw() const noexcept {
    unsigned value = (pdi_operational ? 1U : 0U) | (pdi_watchdog_ok ? 2U : 0U) | (enhanced_link_detection ? 4U : 0U);
    for (unsigned i = 0; i < 4; ++i) {
      value |= ports[i].link ? 0x10U << i : 0U;
      value |= ports[i].loop_closed ? 0x100U << (2 * i) : 0U;
      value |= ports[i].communication ? 0x200U << (2 * i) : 0U;
    }
    return static_cast<std::uint16_t>(value);
  }
  /// Decodes register 0x0110. \rtsafe
  [[nodiscard]] static constexpr DlStatus from_raw(std::uint16_t raw) noexcept {
    DlStatus status;
    status.pdi_operational = (raw & 1U) != 0;
    status.pdi_watchdog_ok = (raw & 2U) != 0;
    status.enhanced_link_detection = (raw & 4U) != 0;
    for (unsigned i = 0; i < 4; ++i) {
      status.ports[i].link = (raw & (0x10U << i)) != 0;
      status.ports[i].loop_closed = (raw & (0x100U << (2 * i))) != 0;
      status.ports[i].communication = (raw & (0x200U << (2 * i))) != 0;
    }
    return status;
  }
  constexpr bool operator==(const DlStatus&) const = default;
};

}  // namespace driveline::wire
