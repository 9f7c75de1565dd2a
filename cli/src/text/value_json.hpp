#pragma once

#include <nlohmann/json_fwd.hpp>

#include "driveline/runtime/config/typed_value.hpp"

namespace driveline::cli {

/// Value of an object as JSON: numbers as numbers, texts as texts, raw bytes as hex text. Error: as for
/// runtime::decode_value().
[[nodiscard]] runtime::Result<nlohmann::json> json_value(std::span<const std::byte> data, runtime::ValueType type);

}  // namespace driveline::cli
