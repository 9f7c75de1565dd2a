#pragma once

#include <string>

#include "driveline/ecat_master/error.hpp"

namespace driveline::runtime {

/// Returns the sentence of an error; for a cycle that is not locked to the reference clock also the remedy.
[[nodiscard]] std::string with_clock_remedy(const ecat_master::Error& error);

}  // namespace driveline::runtime
