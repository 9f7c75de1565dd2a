#include "driveline/runtime/toml/toml_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cmath>

#include "driveline/runtime/toml/suggestion.hpp"
#include "toml/toml_table.hpp"

namespace driveline::runtime {
namespace {

const toml::table& empty_table() {
  static const toml::table kEmpty;
  return kEmpty;
}

std::string_view type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "a boolean";
    default:
      return "a date or time";
  }
}

}  // namespace

TomlReader::TomlReader(std::unique_ptr<Table> table) : table_(std::move(table)) {}
TomlReader::~TomlReader() = default;
TomlReader::TomlReader(TomlReader&& other) noexcept = default;
TomlReader& TomlReader::operator=(TomlReader&& other) noexcept = default;

TomlReader read_toml_table(const toml::table& nodes, std::string file) {
  return TomlReader(std::make_unique<TomlReader::Table>(TomlReader::Table{&nodes, std::move(file), ""}));
}

const toml::node* TomlReader::Table::find(std::string_view key) {
  known.emplace(key);
  return nodes->get(key);
}

std::string TomlReader::Table::where(const toml::node* node, std::string_view key) const {
  const auto line = (node != nullptr ? node->source() : nodes->source()).begin.line;
  std::string place = file;
  if (line > 0) place += fmt::format(":{}", line);
  if (!path.empty()) place += fmt::format(": [{}]", path);
  if (!key.empty()) place += fmt::format("{} {}", path.empty() ? ":" : "", key);
  return place;
}

ConfigError TomlReader::Table::error_at(const toml::node* node, std::string_view key, std::string reason) const {
  const auto line = (node != nullptr ? node->source() : nodes->source()).begin.line;
  return {{ErrorKind::kFile, where(node, key), std::move(reason), file, line}};
}

void TomlReader::fail(std::string_view key, std::string_view reason) const {
  throw table_->error_at(table_->nodes->get(key), key, std::string(reason));
}

std::string TomlReader::place(std::string_view key) const {
  return table_->where(table_->nodes->get(key), key);
}

bool TomlReader::has(std::string_view key) {
  return table_->find(key) != nullptr;
}

bool TomlReader::is_text(std::string_view key) {
  const auto* node = table_->find(key);
  return node != nullptr && node->is_string();
}

std::string TomlReader::text(std::string_view key) {
  const auto* node = table_->find(key);
  if (node == nullptr) fail(key, "is missing, a string is expected");
  if (!node->is_string()) fail(key, fmt::format("is {}, a string is expected", type_name(*node)));
  return node->as_string()->get();
}

std::string TomlReader::text_or(std::string_view key, std::string fallback) {
  return has(key) ? text(key) : std::move(fallback);
}

bool TomlReader::boolean_or(std::string_view key, bool fallback) {
  const auto* node = table_->find(key);
  if (node == nullptr) return fallback;
  if (!node->is_boolean()) fail(key, fmt::format("is {}, true or false is expected", type_name(*node)));
  return node->as_boolean()->get();
}

double TomlReader::number(std::string_view key, double minimum, double maximum) {
  const auto* node = table_->find(key);
  if (node == nullptr) fail(key, "is missing, a number is expected");
  const auto value = node->value<double>();
  if (!node->is_number() || !value) fail(key, fmt::format("is {}, a number is expected", type_name(*node)));
  if (!std::isfinite(*value) || *value < minimum || *value > maximum) {
    fail(key, fmt::format("is {}, {} to {} is expected", *value, minimum, maximum));
  }
  return *value;
}

double TomlReader::number_or(std::string_view key, double fallback, double minimum, double maximum) {
  return has(key) ? number(key, minimum, maximum) : fallback;
}

std::int64_t TomlReader::integer(std::string_view key, std::int64_t minimum, std::int64_t maximum) {
  const auto* node = table_->find(key);
  if (node == nullptr) fail(key, "is missing, an integer is expected");
  if (!node->is_integer()) fail(key, fmt::format("is {}, an integer is expected", type_name(*node)));
  const auto value = node->as_integer()->get();
  if (value < minimum || value > maximum)
    fail(key, fmt::format("is {}, {} to {} is expected", value, minimum, maximum));
  return value;
}

std::int64_t TomlReader::integer_or(std::string_view key, std::int64_t fallback, std::int64_t minimum,
                                    std::int64_t maximum) {
  return has(key) ? integer(key, minimum, maximum) : fallback;
}

std::string TomlReader::scalar_text(std::string_view key) {
  const auto* node = table_->find(key);
  if (node != nullptr && node->is_string()) return node->as_string()->get();
  if (node != nullptr && node->is_integer()) return fmt::format("{}", node->as_integer()->get());
  if (node != nullptr && node->is_floating_point()) return fmt::format("{}", node->as_floating_point()->get());
  fail(key, fmt::format("is {}, a string or a number is expected", node == nullptr ? "missing" : type_name(*node)));
}

bool TomlReader::is_list(std::string_view key) {
  const auto* node = table_->find(key);
  return node != nullptr && node->is_array();
}

std::vector<std::string> TomlReader::scalar_texts(std::string_view key) {
  const auto* node = table_->find(key);
  if (node == nullptr || !node->is_array()) {
    fail(key, fmt::format("is {}, an array is expected", node == nullptr ? "missing" : type_name(*node)));
  }
  std::vector<std::string> texts;
  for (const auto& element : *node->as_array()) {
    if (element.is_string()) {
      texts.push_back(element.as_string()->get());
    } else if (element.is_integer()) {
      texts.push_back(fmt::format("{}", element.as_integer()->get()));
    } else if (element.is_floating_point()) {
      texts.push_back(fmt::format("{}", element.as_floating_point()->get()));
    } else {
      fail(key, fmt::format("contains {}, an array of strings and numbers is expected", type_name(element)));
    }
  }
  return texts;
}

bool TomlReader::holds_texts(std::string_view key) {
  const auto* node = table_->find(key);
  const auto* const array = node == nullptr ? nullptr : node->as_array();
  return array != nullptr && !array->empty() && array->front().is_string();
}

std::vector<double> TomlReader::numbers(std::string_view key, double minimum, double maximum) {
  const auto* node = table_->find(key);
  if (node == nullptr) fail(key, "is missing, an array of numbers is expected");
  if (!node->is_array()) fail(key, fmt::format("is {}, an array of numbers is expected", type_name(*node)));
  std::vector<double> numbers;
  for (const auto& element : *node->as_array()) {
    const auto value = element.value<double>();
    if (!element.is_number() || !value)
      fail(key, fmt::format("contains {}, an array of numbers is expected", type_name(element)));
    if (!std::isfinite(*value) || *value < minimum || *value > maximum)
      fail(key, fmt::format("contains {}, {} to {} is expected", *value, minimum, maximum));
    numbers.push_back(*value);
  }
  return numbers;
}

std::vector<std::string> TomlReader::texts_or(std::string_view key, std::vector<std::string> fallback) {
  const auto* node = table_->find(key);
  if (node == nullptr) return fallback;
  if (!node->is_array()) fail(key, fmt::format("is {}, an array of strings is expected", type_name(*node)));
  std::vector<std::string> texts;
  for (const auto& element : *node->as_array()) {
    if (!element.is_string())
      fail(key, fmt::format("contains {}, an array of strings is expected", type_name(element)));
    texts.push_back(element.as_string()->get());
  }
  return texts;
}

std::size_t TomlReader::choice_or(std::string_view key, std::size_t fallback,
                                  const std::vector<std::string_view>& choices) {
  if (!has(key)) return fallback;
  const auto value = text(key);
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (choices[i] == value) return i;
  }
  const auto meant = closest(value, choices);
  fail(key, fmt::format("is \"{}\", one of \"{}\" is expected{}", value, fmt::join(choices, "\", \""),
                        meant.empty() ? "" : fmt::format("; did you mean \"{}\"?", meant)));
}

std::vector<std::string> TomlReader::keys() {
  std::vector<std::string> keys;
  for (const auto& [key, value] : *table_->nodes) {
    keys.emplace_back(key.str());
    table_->known.emplace(key.str());
  }
  return keys;
}

TomlReader TomlReader::table(std::string_view key) {
  const auto* node = table_->find(key);
  const auto path = table_->path.empty() ? std::string(key) : fmt::format("{}.{}", table_->path, key);
  const auto reader_of = [&](const toml::table& nodes) {
    return TomlReader(std::make_unique<Table>(Table{&nodes, table_->file, path}));
  };
  if (node == nullptr) return reader_of(empty_table());
  if (!node->is_table()) fail(key, fmt::format("is {}, a table is expected", type_name(*node)));
  return reader_of(*node->as_table());
}

std::vector<TomlReader> TomlReader::tables(std::string_view key) {
  const auto* node = table_->find(key);
  if (node == nullptr) return {};
  const auto path = table_->path.empty() ? std::string(key) : fmt::format("{}.{}", table_->path, key);
  if (!node->is_array()) fail(key, fmt::format("is {}, [[{}]] tables are expected", type_name(*node), path));
  std::vector<TomlReader> readers;
  for (const auto& element : *node->as_array()) {
    if (!element.is_table())
      fail(key, fmt::format("contains {}, [[{}]] tables are expected", type_name(element), path));
    readers.emplace_back(std::make_unique<Table>(
        Table{element.as_table(), table_->file, fmt::format("{} {}", path, readers.size() + 1)}));
  }
  return readers;
}

void TomlReader::finish() const {
  const auto& known = table_->known;
  for (const auto& [key, value] : *table_->nodes) {
    if (known.find(key.str()) != known.end()) continue;
    throw table_->error_at(&value, key.str(), fmt::format("unknown key, expected one of: {}", fmt::join(known, ", ")));
  }
}

}  // namespace driveline::runtime
