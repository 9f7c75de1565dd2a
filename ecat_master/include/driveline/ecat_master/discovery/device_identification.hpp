#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Asks all `slaves` at once for their explicit device identification (ETG.1020 "Requesting ID": AL control bit 5; the
/// value appears in register 0x0134, AL status bit 5 tells when). Slaves that do not know the request leave it
/// unanswered and have no value. The AL state stays; slaves that report an error are not asked, their register holds
/// the AL status code. Errors: those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<std::optional<std::uint16_t>>> read_device_ids(
    Bus& bus, std::span<const SlaveRef> slaves, std::chrono::nanoseconds timeout = std::chrono::milliseconds{100});

}  // namespace driveline::ecat_master
