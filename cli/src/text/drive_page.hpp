#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "driveline/slaves/msd/indicators.hpp"
#include "text/drive_view.hpp"

namespace driveline::cli {

/// Content of the seven-segment display, from the objects of the drive: its state by 6041h, STO by 2079h, the start by
/// P 2060. Fault number and location have no object in the manual; the simulated drives keep them in 1003h:01. No
/// object tells whether a fault needs a remedy first (the point behind Er).
[[nodiscard]] slaves::msd::DisplayContent display_content(const DriveView& view);

/// The page of one drive, `shown_for` after the display's content has last changed. Lines end in '\n'.
[[nodiscard]] std::string drive_page(const DriveView& view, std::chrono::nanoseconds shown_for);

/// The same for programs.
[[nodiscard]] nlohmann::json drive_json(const DriveView& view);

/// The class of a CiA 402 error code (CiA 402-1, error codes), e.g. "voltage"; empty for 0 and unknown classes.
[[nodiscard]] std::string_view error_class(std::uint16_t code) noexcept;

}  // namespace driveline::cli
