#pragma once

#include <optional>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Unlocks a slave, or all of them, whose registers have been locked against writes, by another master or a damaged
/// frame (ESC data sheet II, 0x0020 to 0x0031). Errors: those of the exchange; no answer is no error. Not real-time
/// safe.
[[nodiscard]] Result<void> lift_write_protection(Bus& bus, std::optional<SlaveRef> slave);

}  // namespace driveline::ecat_master
