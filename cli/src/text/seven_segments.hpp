#pragma once

#include <array>
#include <string>

#include "driveline/slaves/msd/indicators.hpp"

namespace driveline::cli {

/// A seven-segment display of two digits, drawn in three rows of nine characters. Knows digits, E, r, S and blank;
/// another symbol is drawn as it is.
[[nodiscard]] std::array<std::string, 3> draw_display(const slaves::msd::DisplayFrame& frame);

}  // namespace driveline::cli
