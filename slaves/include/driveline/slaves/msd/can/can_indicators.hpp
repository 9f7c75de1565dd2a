#pragma once

#include <chrono>

#include "driveline/canopen_wire/nmt.hpp"

namespace driveline::slaves::msd {

/// Whether the yellow LED H14 is lit in this NMT state at this time (MSD manual Table 4.2): it flashes with a cycle of
/// 100 ms, 800 ms or 1600 ms, half of it lit (ours), and is steady in Operational. \rtsafe
[[nodiscard]] bool network_led_h14(canopen::NmtState state, std::chrono::nanoseconds time) noexcept;

}  // namespace driveline::slaves::msd
