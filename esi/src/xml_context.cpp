#include "xml_context.hpp"

#include <algorithm>

#include "driveline/esi/hex.hpp"

namespace driveline::esi {
namespace {

constexpr std::uint32_t kEnglish = 1033;

std::size_t offset_of(pugi::xml_node node) {
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
}

/// Returns the name of the element, with its number among siblings of the same name when there are several.
std::string step_of(pugi::xml_node node) {
  std::size_t number = 1;
  for (auto before = node.previous_sibling(node.name()); before; before = before.previous_sibling(node.name())) {
    ++number;
  }
  const bool alone = number == 1 && !node.next_sibling(node.name());
  return alone ? std::string(node.name()) : fmt::format("{}[{}]", node.name(), number);
}

}  // namespace

XmlContext::XmlContext(std::string_view text, std::string_view file_name) : file_name_(file_name), line_starts_{0} {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') line_starts_.push_back(i + 1);
  }
}

std::size_t XmlContext::line_of(std::size_t offset) const {
  return static_cast<std::size_t>(std::upper_bound(line_starts_.begin(), line_starts_.end(), offset) -
                                  line_starts_.begin());
}

std::string XmlContext::path_of(pugi::xml_node node) {
  std::string path;
  for (; node.type() == pugi::node_element; node = node.parent()) {
    path = path.empty() ? step_of(node) : fmt::format("{}/{}", step_of(node), path);
  }
  return path;
}

void XmlContext::note(pugi::xml_node node, std::string text) {
  if (notes_.size() > kMaxNotes) return;
  if (notes_.size() == kMaxNotes) text = "and more; further notes are omitted";
  notes_.push_back({line_of(offset_of(node)), path_of(node), std::move(text)});
}

void XmlContext::fail(pugi::xml_node node, const std::string& problem, std::string expected) {
  if (error_) return;
  const std::size_t offset = offset_of(node);
  error_ = EsiError{file_name_, line_of(offset), offset, path_of(node), shortened(problem), std::move(expected)};
}

void XmlContext::fail_at(std::size_t offset, std::string problem) {
  if (!error_) error_ = EsiError{file_name_, line_of(offset), offset, {}, std::move(problem), {}};
}

bool XmlContext::attribute_flag(pugi::xml_node node, const char* attribute) {
  const auto found = node.attribute(attribute);
  if (!found) return false;
  const std::string text = lower_case(trimmed(found.value()));
  if (text == "true") return true;
  if (text == "false") return false;
  if (const auto value = parse_number<std::uint32_t>(text)) return *value != 0;
  fail(node, fmt::format("{}='{}'", attribute, text), "true, false or a number");
  return false;
}

bool XmlContext::attribute_bit(pugi::xml_node node, const char* attribute) {
  if (const auto value = parse_number<std::uint32_t>(node.attribute(attribute).value())) return (*value & 1U) != 0;
  return attribute_flag(node, attribute);
}

std::string XmlContext::text_of(pugi::xml_node node) {
  return std::string(trimmed(node.text().get()));
}

std::string XmlContext::child_text(pugi::xml_node parent, const char* child) {
  return text_of(parent.child(child));
}

std::string XmlContext::localized_text(pugi::xml_node parent, const char* child) {
  for (const auto node : parent.children(child)) {
    if (parse_number<std::uint32_t>(node.attribute("LcId").value()) == kEnglish) return text_of(node);
  }
  return child_text(parent, child);
}

std::string XmlContext::child_hex(pugi::xml_node parent, const char* child) {
  const auto node = parent.child(child);
  const auto bytes = parse_hex(node.text().get());
  if (!bytes) {
    fail(node, fmt::format("'{}'", text_of(node)), "hexadecimal digits, two for each byte");
    return {};
  }
  return to_hex(*bytes);
}

}  // namespace driveline::esi
