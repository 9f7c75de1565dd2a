#pragma once

#include <string>
#include <string_view>

#include "driveline/runtime/line.hpp"

namespace driveline::cli {

/// Answers a question about a running CAN line, on the thread that owns it: "diag", "diag json"; a sentence about what
/// a CAN bus does not have.
[[nodiscard]] std::string answer_about_can(runtime::Line& line, std::string_view question);

}  // namespace driveline::cli
