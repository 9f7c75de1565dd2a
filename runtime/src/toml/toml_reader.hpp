#pragma once

#include <toml++/toml.h>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <vector>
#include "driveline/runtime/error.hpp"

#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// What is wrong in a file. Thrown inside the readers only.
struct ConfigError {
  Error error;
};

/// Typed access to one TOML table that knows where it is and which keys were asked for. All errors are ConfigErrors of
/// the form "file:line: [table] key: reason".
class TomlReader {
 public:
  /// `path` names the table in errors; empty for the root.
  TomlReader(const toml::table& table, std::string file, std::string path);

  [[nodiscard]] bool has(std::string_view key);
  /// Whether the value of this key is a string.
  [[nodiscard]] bool is_text(std::string_view key);
  [[nodiscard]] std::string text(std::string_view key);
  [[nodiscard]] std::string text_or(std::string_view key, std::string fallback);
  [[nodiscard]] bool boolean_or(std::string_view key, bool fallback);
  /// A number within minimum..maximum; integers are accepted for numbers.
  [[nodiscard]] double number(std::string_view key, double minimum, double maximum);
  [[nodiscard]] double number_or(std::string_view key, double fallback, double minimum, double maximum);
  [[nodiscard]] std::int64_t integer(std::string_view key, std::int64_t minimum, std::int64_t maximum);
  [[nodiscard]] std::int64_t integer_or(std::string_view key, std::int64_t fallback, std::int64_t minimum,
                                        std::int64_t maximum);
  /// The value of a string, or a number as text.
  [[nodiscard]] std::string scalar_text(std::string_view key);
  /// An array of numbers within minimum..maximum.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, double minimum, double maximum);
  [[nodiscard]] std::vector<std::string> texts_or(std::string_view key, std::vector<std::string> fallback);
  /// The position of the value in `choices`.
  [[nodiscard]] std::size_t choice_or(std::string_view key, std::size_t fallback,
                                      const std::vector<std::string_view>& choices);

  /// All keys of the table, in the order of the alphabet. They count as read.
  [[nodiscard]] std::vector<std::string> keys();

  /// A sub-table; an empty one when it is left out.
  [[nodiscard]] TomlReader table(std::string_view key);
  /// An array of tables; none when it is left out.
  [[nodiscard]] std::vector<TomlReader> tables(std::string_view key);

  /// To be called when everything has been read: throws a ConfigError for the first key that was not read.
  void finish() const;

  /// Throws a ConfigError that points at `key` (or at the table when there is no such key).
  [[noreturn]] void fail(std::string_view key, std::string_view reason) const;
  /// "file:line: [table] key", for complaints that can only be made once the line is there.
  [[nodiscard]] std::string place(std::string_view key) const { return where(table_->get(key), key); }

 private:
  [[nodiscard]] const toml::node* find(std::string_view key);
  [[nodiscard]] ConfigError error_at(const toml::node* node, std::string_view key, std::string reason) const;
  [[nodiscard]] std::string where(const toml::node* node, std::string_view key) const;

  const toml::table* table_;
  std::string file_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
};

}  // namespace driveline::runtime
