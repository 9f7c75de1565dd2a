#include "xml_writer.hpp"

#include <fmt/format.h>

#include "utf8.hpp"

namespace driveline::esi {

std::string xml_text(std::string_view text) {
  std::string out = to_utf8(text);
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return out;
}

std::string hex_number(std::uint32_t value, int digits) {
  return fmt::format("#x{:0{}X}", value, digits);
}

pugi::xml_node append_text(pugi::xml_node parent, const char* name, std::string_view text) {
  auto node = parent.append_child(name);
  node.text().set(xml_text(text).c_str());
  return node;
}

void append_name(pugi::xml_node parent, std::string_view text) {
  append_text(parent, "Name", text).append_attribute("LcId") = "1033";
}

}  // namespace driveline::esi
