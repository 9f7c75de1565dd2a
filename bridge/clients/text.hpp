#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "value.hpp"

namespace driveline::bridge::clients {

/// Formats a sample as YAML, one field per line, like `ros2 topic echo`.
[[nodiscard]] std::string yaml_text(const Value& sample);
/// Formats a sample as JSON in one line. NaN and infinity become null; enumerations become their names.
[[nodiscard]] std::string json_text(const Value& sample);
/// Formats a JSON string with its quotes; bytes that are not UTF-8 become U+00XX.
[[nodiscard]] std::string json_string(std::string_view text);
/// Makes text safe for a terminal: control characters and invalid UTF-8 become a backslash, x and two hexadecimal
/// digits.
[[nodiscard]] std::string visible(std::string_view text);

/// Column names of a topic in a table: fields in the order of the type, those of structures after a dot; row fields of
/// a sample with several rows (Topic::rows) have their own names.
[[nodiscard]] std::vector<std::string> table_columns(const Topic& topic);
/// Formats the rows of a sample; each starts with `head`, the text of the first cells with a comma after each.
[[nodiscard]] std::string table_rows(const Topic& topic, const Value& sample, std::string_view head);

}  // namespace driveline::bridge::clients
