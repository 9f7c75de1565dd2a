#pragma once

#include "dc/bring_up.hpp"

namespace driveline::ecat_master::dc {

/// Static drift compensation: sends the reference clock's time to all other clocks often enough for their control loops
/// to learn the frequency, then until the differences are small enough; computes the mapping of the master's clock from
/// the same frames; see bring_up_clocks(), steps 5 and 6. clocks.mapping must already be roughly right.
[[nodiscard]] Result<void> compensate_drift(Bus& bus, std::span<const SlaveRef> slaves,
                                            std::span<const ClockFeatures> features, const ClockPlan& plan,
                                            LineClocks& clocks);

}  // namespace driveline::ecat_master::dc
