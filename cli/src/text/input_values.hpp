#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "driveline/runtime/record/input_values.hpp"

namespace driveline::cli {

/// One row per input: name, object, bits, bit pattern and number.
[[nodiscard]] std::string to_text(std::span<const runtime::InputValue> inputs);
[[nodiscard]] nlohmann::json to_json(std::span<const runtime::InputValue> inputs);

}  // namespace driveline::cli
