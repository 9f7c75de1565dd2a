#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "text/visible_text.hpp"

namespace driveline::cli {

/// A document as text for output. Texts of devices and files need not be UTF-8: invalid bytes become U+FFFD, and
/// control characters become JSON escapes.
[[nodiscard]] inline std::string json_text(const nlohmann::json& document) {
  return visible_json(document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace)) + "\n";
}

}  // namespace driveline::cli
