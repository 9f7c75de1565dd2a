#pragma once

#include <cstdint>

#include "driveline/slaves/msd/core/variant.hpp"

namespace driveline::slaves::msd {

/// DIP switch S4 of the CAN connection (MSD manual 4.4.2): hardware address and terminating resistor. Compact devices
/// and the ServoOne junior have seven switches, the others eight; the last one is the resistor.
struct DipSwitch {
  std::uint8_t on = 0;  ///< bit n: switch n + 1 is on

  /// Returns the hardware address, 0 to 127, or to 63 with seven switches. \rtsafe
  [[nodiscard]] constexpr std::uint8_t address(Series series) const noexcept {
    return static_cast<std::uint8_t>(on & (resistor_bit(series) - 1U));
  }
  /// Whether the resistor of 120 ohm terminates the bus. \rtsafe
  [[nodiscard]] constexpr bool terminates(Series series) const noexcept { return (on & resistor_bit(series)) != 0; }

 private:
  [[nodiscard]] static constexpr unsigned resistor_bit(Series series) noexcept {
    return series == Series::kCompact || series == Series::kServoOneJunior ? 0x40U : 0x80U;
  }
};

}  // namespace driveline::slaves::msd
