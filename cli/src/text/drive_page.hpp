#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "driveline/slaves/msd/indicators.hpp"
#include "text/drive_view.hpp"

namespace driveline::cli {

/// Content of the seven-segment display, derived from the objects of the drive: state from 6041h, STO from 2079h, start
/// from P 2060. The manual names no object with number and location of a fault; the simulated drives store them in
/// 1003h:01. No object tells whether a fault needs a remedy first (the decimal point after Er).
[[nodiscard]] slaves::msd::DisplayContent display_content(const DriveView& view);

/// The page of a drive, `shown_for` after the last change of the display's content. Lines end in '\n'.
[[nodiscard]] std::string drive_page(const DriveView& view, std::chrono::nanoseconds shown_for);

/// The content of the page as a JSON document.
[[nodiscard]] nlohmann::json drive_json(const DriveView& view);

/// The class of a CiA 402 error code (CiA 402-1, error codes), e.g. "voltage"; empty for 0 and unknown classes.
[[nodiscard]] std::string_view error_class(std::uint16_t code) noexcept;

}  // namespace driveline::cli
