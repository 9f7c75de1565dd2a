#pragma once

#include <array>
#include <string>

#include "driveline/slaves/msd/indicators.hpp"

namespace driveline::cli {

/// Draws a two-digit seven-segment display in three rows of nine characters. Knows digits, E, r, S and blank; any other
/// symbol is drawn as it is.
[[nodiscard]] std::array<std::string, 3> draw_display(const slaves::msd::DisplayFrame& frame);

}  // namespace driveline::cli
