#include "text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

namespace driveline::bridge::clients {
namespace {

/// Number of bytes of the UTF-8 character at the start (RFC 3629, section 4); 0: invalid.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto follows = [&](std::size_t i, unsigned from = 0x80, unsigned to = 0xBF) {
    return byte(i) >= from && byte(i) <= to;
  };
  const auto first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return follows(1) ? 2 : 0;
  if (first >= 0xE0 && first <= 0xEF) {
    const bool second = follows(1, first == 0xE0 ? 0xA0 : 0x80, first == 0xED ? 0x9F : 0xBF);
    return second && follows(2) ? 3 : 0;
  }
  if (first >= 0xF0 && first <= 0xF4) {
    const bool second = follows(1, first == 0xF0 ? 0x90 : 0x80, first == 0xF4 ? 0x8F : 0xBF);
    return second && follows(2) && follows(3) ? 4 : 0;
  }
  return 0;
}

/// Whether a character up to 0x9F controls a terminal instead of being shown (C0, DEL, C1).
bool controls(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first < 0x20 || first == 0x7F;
  return character.size() == 2 && first == 0xC2 && static_cast<unsigned char>(character[1]) < 0xA0;
}

/// `text` with every byte of a control character or of invalid UTF-8 replaced by `escape`.
template <class Escape>
std::string escaped(std::string_view text, Escape escape) {
  std::string safe;
  while (!text.empty()) {
    const auto length = utf8_length(text);
    const auto character = text.substr(0, length == 0 ? 1 : length);
    if (length == 0 || controls(character)) {
      for (const char c : character) safe += escape(static_cast<unsigned char>(c));
    } else {
      safe += character;
    }
    text.remove_prefix(character.size());
  }
  return safe;
}

std::string real_text(double value, std::string_view not_a_number) {
  if (!std::isfinite(value)) return std::string(not_a_number);
  return fmt::format("{}", value);
}

/// Text of a value that is not a string.
std::string number_text(const Value& value, std::string_view not_a_number) {
  if (const auto* truth = std::get_if<bool>(&value.scalar)) return *truth ? "true" : "false";
  if (const auto* real = std::get_if<double>(&value.scalar)) return real_text(*real, not_a_number);
  if (const auto* with_sign = std::get_if<std::int64_t>(&value.scalar)) return fmt::format("{}", *with_sign);
  return fmt::format("{}", value.whole());
}

bool is_string(const Value& value) {
  return std::holds_alternative<std::string_view>(value.scalar);
}

/// Text that YAML would not accept unquoted is quoted as JSON, which YAML accepts.
std::string yaml_scalar(const Value& value) {
  if (!is_string(value)) return value.text().empty() ? number_text(value, ".nan") : std::string(value.text());
  const auto text = value.text();
  constexpr std::string_view kSpecial = ":#'\"\\{}[],&*!|>%@`\n";
  const bool plain = !text.empty() && text.find_first_of(kSpecial) == std::string_view::npos && text[0] != '-' &&
                     text[0] != ' ' && text.back() != ' ' && visible(text) == text;
  return plain ? std::string(text) : json_string(text);
}

void add_yaml(const Value& value, std::size_t depth, std::string& to);

void add_yaml_field(const Value& value, std::size_t depth, std::string& to) {
  to += value.field->name;
  to += ':';
  if (value.sequence) {
    to += value.parts.empty() ? " []\n" : "\n";
    for (const auto& part : value.parts) {
      to += std::string(depth, ' ') + "- ";
      if (part.structure != nullptr) {
        add_yaml(part, depth + 2, to);
      } else {
        to += yaml_scalar(part) + '\n';
      }
    }
  } else if (value.structure != nullptr) {
    to += '\n' + std::string(depth + 2, ' ');
    add_yaml(value, depth + 2, to);
  } else {
    to += ' ' + yaml_scalar(value) + '\n';
  }
}

/// Appends the fields of a structure; the first one follows at the end of `to`.
void add_yaml(const Value& value, std::size_t depth, std::string& to) {
  bool first = true;
  for (const auto& part : value.parts) {
    if (!first) to += std::string(depth, ' ');
    first = false;
    add_yaml_field(part, depth, to);
  }
}

void add_json(const Value& value, std::string& to) {
  if (value.sequence || value.structure != nullptr) {
    to += value.sequence ? '[' : '{';
    const auto begin = to.size();
    for (const auto& part : value.parts) {
      if (to.size() != begin) to += ',';
      if (!value.sequence) to += json_string(part.field->name) + ':';
      add_json(part, to);
    }
    to += value.sequence ? ']' : '}';
  } else {
    to += is_string(value) || !value.text().empty() ? json_string(value.text()) : number_text(value, "null");
  }
}

std::string csv_text(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c;
    if (c == '"') quoted += c;
  }
  return quoted + '"';
}

/// Appends the cells of a value, each followed by a comma. A sequence is one cell, its elements separated by spaces,
/// strings as JSON.
void add_cells(const Value& value, std::string& to) {
  if (value.sequence) {
    std::string cell;
    for (const auto& part : value.parts) {
      if (!cell.empty()) cell += ' ';
      add_json(part, cell);
    }
    to += csv_text(cell);
  } else if (value.structure != nullptr) {
    for (const auto& part : value.parts) add_cells(part, to);
    return;
  } else if (is_string(value)) {
    to += csv_text(value.text());
  } else {
    to += value.text().empty() ? number_text(value, "nan") : std::string(value.text());
  }
  to += ',';
}

void add_columns(const StructType& structure, const std::string& prefix, std::vector<std::string>& to) {
  for (const auto& field : structure.fields) {
    const auto name = prefix + std::string(field.name);
    if (field.kind == Kind::kStruct && !field.sequence && field.count == 0) {
      add_columns(*field.structure, name + '.', to);
    } else {
      to.push_back(name);
    }
  }
}

const Field& field_of(const StructType& structure, std::string_view name) {
  std::size_t i = 0;
  while (structure.fields[i].name != name) ++i;  // make_topics.py has checked that the field exists
  return structure.fields[i];
}

}  // namespace

std::string visible(std::string_view text) {
  return escaped(text, [](unsigned char byte) { return fmt::format("\\x{:02X}", byte); });
}

std::string json_string(std::string_view text) {
  std::string safe = "\"";
  for (const char c : escaped(text, [](unsigned char byte) { return std::string{'\1', static_cast<char>(byte)}; })) {
    // Escaped bytes are marked by a preceding control character, which escaped text cannot contain otherwise.
    if (!safe.empty() && safe.back() == '\1') {
      safe.pop_back();
      safe += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    } else if (c == '"' || c == '\\') {
      safe += std::string{'\\', c};
    } else {
      safe += c;
    }
  }
  return safe + '"';
}

std::string yaml_text(const Value& sample) {
  std::string text;
  add_yaml(sample, 0, text);
  return text;
}

std::string json_text(const Value& sample) {
  std::string text;
  add_json(sample, text);
  return text;
}

std::vector<std::string> table_columns(const Topic& topic) {
  std::vector<std::string> columns;
  if (topic.rows.empty()) {
    add_columns(*topic.structure, "", columns);
    return columns;
  }
  for (const auto& field : topic.structure->fields) {
    if (field.name != topic.rows && field.name != topic.partners) columns.emplace_back(field.name);
  }
  if (!topic.partners.empty()) add_columns(*field_of(*topic.structure, topic.partners).structure, "", columns);
  add_columns(*field_of(*topic.structure, topic.rows).structure, "", columns);
  return columns;
}

std::string table_rows(const Topic& topic, const Value& sample, std::string_view head) {
  std::string text(head);
  if (topic.rows.empty()) {
    add_cells(sample, text);
    text.back() = '\n';
    return text;
  }
  for (const auto& part : sample.parts) {
    if (part.field->name != topic.rows && part.field->name != topic.partners) add_cells(part, text);
  }
  const auto common = std::move(text);
  text.clear();
  const auto* const partners = sample.find(topic.partners);
  for (const auto& row : sample.find(topic.rows)->parts) {
    if (partners != nullptr) {
      const auto index = row.find(topic.partner_index)->whole();
      if (index >= partners->parts.size()) continue;  // the bridge never publishes such a sample
      text += common;
      add_cells(partners->parts[index], text);
    } else {
      text += common;
    }
    add_cells(row, text);
    text.back() = '\n';
  }
  return text;
}

}  // namespace driveline::bridge::clients
