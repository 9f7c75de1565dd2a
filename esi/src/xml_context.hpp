#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "driveline/esi/esi_file.hpp"
#include "text.hpp"

namespace driveline::esi {

/// Reads typed values from XML elements and records the first error and the notes with their positions.
///
/// A value that cannot be read becomes its default, and the first such failure is stored; the reader continues and
/// checks for an error once at the end. So the readers need no error handling of their own, as they have no side
/// effects before that check.
class XmlContext {
 public:
  XmlContext(std::string_view text, std::string_view file_name);

  void note(pugi::xml_node node, std::string text);
  void fail(pugi::xml_node node, const std::string& problem, std::string expected);
  void fail_at(std::size_t offset, std::string problem);
  [[nodiscard]] const std::optional<EsiError>& error() const { return error_; }
  [[nodiscard]] std::vector<EsiNote> take_notes() { return std::move(notes_); }

  /// Returns the number in `text`: decimal, or hexadecimal with #x or 0x. Returns `fallback` and stores an error when
  /// the text is not a number or out of range.
  template <typename T>
  [[nodiscard]] T number(pugi::xml_node node, std::string_view text, T fallback);
  /// Returns the number in the child element, `fallback` when there is no such child.
  template <typename T>
  [[nodiscard]] T child_number(pugi::xml_node parent, const char* child, T fallback = 0);
  template <typename T>
  [[nodiscard]] T attribute_number(pugi::xml_node node, const char* attribute, T fallback = 0);
  /// Returns a Boolean attribute; a missing attribute is false, a non-zero number is true.
  [[nodiscard]] bool attribute_flag(pugi::xml_node node, const char* attribute);
  /// Returns a Boolean attribute that may also be a register value, in which case bit 0 decides.
  [[nodiscard]] bool attribute_bit(pugi::xml_node node, const char* attribute);

  /// Returns the text of an element without surrounding white space.
  [[nodiscard]] static std::string text_of(pugi::xml_node node);
  [[nodiscard]] static std::string child_text(pugi::xml_node parent, const char* child);
  /// Returns the text of the child element, the English one (LcId 1033) if there are several, else the first.
  [[nodiscard]] std::string localized_text(pugi::xml_node parent, const char* child);
  /// Returns the hexBinary content of the child element in upper case; empty when there is no such child.
  [[nodiscard]] std::string child_hex(pugi::xml_node parent, const char* child);

 private:
  [[nodiscard]] std::size_t line_of(std::size_t offset) const;
  [[nodiscard]] static std::string path_of(pugi::xml_node node);

  std::string file_name_;
  std::vector<std::size_t> line_starts_;
  std::optional<EsiError> error_;
  std::vector<EsiNote> notes_;
};

/// Returns the value of a decimal, #x or 0x number that fits into T; nullopt when the text contains anything else.
template <typename T>
[[nodiscard]] std::optional<T> parse_number(std::string_view text) {
  text = trimmed(text);
  int base = 10;
  if (text.starts_with("#x") || text.starts_with("#X") || text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
    if (text.starts_with('-')) return std::nullopt;
  } else if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return std::nullopt;
  }
  T value{};
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <typename T>
T XmlContext::number(pugi::xml_node node, std::string_view text, T fallback) {
  static_assert(std::is_integral_v<T>);
  if (const auto value = parse_number<T>(text)) return *value;
  fail(node, fmt::format("'{}'", trimmed(text)),
       fmt::format("a number from {} to {} as 16, #x10 or 0x10", std::numeric_limits<T>::min(),
                   std::numeric_limits<T>::max()));
  return fallback;
}

template <typename T>
T XmlContext::child_number(pugi::xml_node parent, const char* child, T fallback) {
  const auto node = parent.child(child);
  return node ? number(node, node.text().get(), fallback) : fallback;
}

template <typename T>
T XmlContext::attribute_number(pugi::xml_node node, const char* attribute, T fallback) {
  const auto found = node.attribute(attribute);
  return found ? number(node, found.value(), fallback) : fallback;
}

}  // namespace driveline::esi
