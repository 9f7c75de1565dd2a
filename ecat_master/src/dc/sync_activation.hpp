#pragma once

#include "dc/bring_up.hpp"

namespace driveline::ecat_master::dc {

/// Writes and activates the signals of `clocks` (whose start times are filled in); see bring_up_clocks(), step 7. After
/// an error none of these signals is active; those of other slaves continue.
[[nodiscard]] Result<void> activate_signals(Bus& bus, std::span<const SlaveRef> slaves, std::chrono::nanoseconds lead,
                                            LineClocks& clocks);

}  // namespace driveline::ecat_master::dc
