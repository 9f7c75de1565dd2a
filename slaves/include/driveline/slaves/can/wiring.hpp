#pragma once

#include <cstdint>

namespace driveline::slaves::can {

/// The cable of a bus.
struct Wiring {
  double length_m = 10.0;        ///< from the first node to the last one
  bool first_terminated = true;  ///< 120 ohm at the end of the first node
  bool last_terminated = true;   ///< 120 ohm at the end of the last node
};

/// Longest cable in metres for a bit rate in bit/s (MSD manual 4.6.3, Table 4.8: 25 m at 1 Mbit/s to 2500 m at
/// 20 kbit/s). In a longer one the acknowledge comes too late. \rtsafe
[[nodiscard]] double longest_cable_m(std::uint32_t bit_rate) noexcept;

/// Highest bit rate at which reflections do no harm on a cable of which `terminators` ends, 0 to 2, have a resistor.
/// Ours: it is known that slow buses work without one and fast ones do not, the values depend on the cable. \rtsafe
[[nodiscard]] std::uint32_t highest_bit_rate(unsigned terminators) noexcept;

}  // namespace driveline::slaves::can
