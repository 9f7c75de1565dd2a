#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Reads the explicit device identification of all `slaves` at once (ETG.1020 "Requesting ID": AL control bit 5; the
/// value appears in register 0x0134 when AL status bit 5 is set). Slaves that do not support the request leave it
/// unanswered and return no value. The AL state does not change; slaves that report an error are skipped, because their
/// register holds the AL status code. Errors: those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<std::optional<std::uint16_t>>> read_device_ids(
    Bus& bus, std::span<const SlaveRef> slaves, std::chrono::nanoseconds timeout = std::chrono::milliseconds{100});

}  // namespace driveline::ecat_master
