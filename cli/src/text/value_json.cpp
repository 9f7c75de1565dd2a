#include "text/value_json.hpp"

#include <nlohmann/json.hpp>

namespace driveline::cli {

runtime::Result<nlohmann::json> json_value(std::span<const std::byte> data, runtime::ValueType type) {
  return runtime::decode_value(data, type).map([](const runtime::TypedValue& value) {
    return std::visit([](const auto& content) { return nlohmann::json(content); }, value);
  });
}

}  // namespace driveline::cli
