#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/canopen_port/can_port.hpp"

namespace driveline::canopen {

/// Takes what an error frame of linux/can/error.h tells of the bus into the counters: the state of the controller, its
/// error counters, lost frames. `classes`: bits of socketcan::error_class; `data`: eight bytes, or none. \rtsafe
void apply_error_frame(PortStatistics& counters, std::uint32_t classes, std::span<const std::byte> data) noexcept;

}  // namespace driveline::canopen
