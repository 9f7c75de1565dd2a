#pragma once

#include <cstdint>
#include <pugixml.hpp>
#include <string>
#include <string_view>

namespace driveline::esi {

/// Converts the text to valid XML text: UTF-8, control characters replaced by spaces.
[[nodiscard]] std::string xml_text(std::string_view text);

/// Formats the number as in ESI files: #x and at least `digits` upper-case hexadecimal digits.
[[nodiscard]] std::string hex_number(std::uint32_t value, int digits);

/// Appends an element that contains a text.
pugi::xml_node append_text(pugi::xml_node parent, const char* name, std::string_view text);

/// Appends a Name element in English.
void append_name(pugi::xml_node parent, std::string_view text);

}  // namespace driveline::esi
