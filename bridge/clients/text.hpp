#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "value.hpp"

namespace driveline::bridge::clients {

/// A sample as `ros2 topic echo` would print it: YAML, a field per line.
[[nodiscard]] std::string yaml_text(const Value& sample);
/// A sample as JSON in one line. What is no number (NaN, infinity) is null; enumerations are their names.
[[nodiscard]] std::string json_text(const Value& sample);
/// A string of JSON with its quotes; bytes that are no UTF-8 are as U+00XX.
[[nodiscard]] std::string json_string(std::string_view text);
/// Text for a terminal: nothing in it can control one. Control characters and what is no UTF-8 are as a backslash, x
/// and two hexadecimal digits.
[[nodiscard]] std::string visible(std::string_view text);

/// The columns of a topic in a table: fields in the order of the type, those of structures behind a dot; what belongs
/// to a row of a sample with several (Topic::rows) has its own name.
[[nodiscard]] std::vector<std::string> table_columns(const Topic& topic);
/// The rows of a sample; each begins with `head`, which is the text of the first cells with a comma behind each.
[[nodiscard]] std::string table_rows(const Topic& topic, const Value& sample, std::string_view head);

}  // namespace driveline::bridge::clients
