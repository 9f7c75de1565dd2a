#pragma once

#include <optional>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Unlocks a slave, or all slaves, whose registers were write-protected by another master or a damaged frame (ESC data
/// sheet II, 0x0020 to 0x0031). Errors: those of the exchange; a missing answer is not an error. Not real-time safe.
[[nodiscard]] Result<void> lift_write_protection(Bus& bus, std::optional<SlaveRef> slave);

}  // namespace driveline::ecat_master
