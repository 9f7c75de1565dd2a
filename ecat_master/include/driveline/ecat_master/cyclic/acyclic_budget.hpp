#pragma once

#include <chrono>
#include <cstddef>

#include "driveline/ecat_master/process_data/process_image.hpp"

namespace driveline::ecat_master {

/// Bytes of acyclic frames per cycle that do not delay the frames of the next cycle: nine tenths of `period` minus
/// wire_time_ns(), at least the shortest frame, at most AcyclicChannel::kMaxBytes.
[[nodiscard]] std::size_t acyclic_bytes(const ProcessImage& image, bool clocks, std::chrono::nanoseconds period);

}  // namespace driveline::ecat_master
