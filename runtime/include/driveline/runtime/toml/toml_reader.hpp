#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// An error in a file. The readers throw it, and load_line_config() returns it as the error of the file; code in
/// between (such as a DeviceFamily) must not catch it.
struct ConfigError {
  Error error;  ///< with file and line
};

/// Typed access to one table of a TOML file. Knows its place in the file, and which keys were read. A key that is
/// missing, has another type or is out of range throws a ConfigError: "file:line: [table] key: reason". Must not be
/// used on real-time threads.
class TomlReader {
 public:
  struct Table;  ///< table of the file, as its parser represents it
  /// Readers are made by read_toml_table(), those of sub-tables by table().
  explicit TomlReader(std::unique_ptr<Table> table);
  ~TomlReader();
  /// A moved-from reader can only be destroyed or assigned to.
  TomlReader(TomlReader&& other) noexcept;
  TomlReader& operator=(TomlReader&& other) noexcept;

  /// Whether the key exists, with a value of any type.
  [[nodiscard]] bool has(std::string_view key);
  /// Whether the value of this key is a string.
  [[nodiscard]] bool is_text(std::string_view key);
  /// Whether the value of this key is an array whose first element is a string.
  [[nodiscard]] bool holds_texts(std::string_view key);
  /// Returns a string.
  [[nodiscard]] std::string text(std::string_view key);
  /// Returns a string; `fallback` if the key is missing.
  [[nodiscard]] std::string text_or(std::string_view key, std::string fallback);
  /// Returns true or false; `fallback` if the key is missing.
  [[nodiscard]] bool boolean_or(std::string_view key, bool fallback);
  /// Returns a number within minimum..maximum; integers are accepted, too.
  [[nodiscard]] double number(std::string_view key, double minimum, double maximum);
  /// Same; `fallback` if the key is missing.
  [[nodiscard]] double number_or(std::string_view key, double fallback, double minimum, double maximum);
  /// Returns an integer within minimum..maximum.
  [[nodiscard]] std::int64_t integer(std::string_view key, std::int64_t minimum, std::int64_t maximum);
  /// Same; `fallback` if the key is missing.
  [[nodiscard]] std::int64_t integer_or(std::string_view key, std::int64_t fallback, std::int64_t minimum,
                                        std::int64_t maximum);
  /// Returns a string, or a number as text.
  [[nodiscard]] std::string scalar_text(std::string_view key);
  /// Whether the value of this key is an array.
  [[nodiscard]] bool is_list(std::string_view key);
  /// Returns an array of strings and numbers, each as scalar_text() has it.
  [[nodiscard]] std::vector<std::string> scalar_texts(std::string_view key);
  /// Returns an array of numbers within minimum..maximum.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, double minimum, double maximum);
  /// Returns an array of strings; `fallback` if the key is missing.
  [[nodiscard]] std::vector<std::string> texts_or(std::string_view key, std::vector<std::string> fallback);
  /// Returns the index of the value in `choices`; `fallback` if the key is missing.
  [[nodiscard]] std::size_t choice_or(std::string_view key, std::size_t fallback,
                                      const std::vector<std::string_view>& choices);

  /// Returns all keys of the table, in alphabetical order. They count as read.
  [[nodiscard]] std::vector<std::string> keys();

  /// Returns a sub-table; an empty one if the key is missing.
  [[nodiscard]] TomlReader table(std::string_view key);
  /// Returns an array of tables; empty if the key is missing.
  [[nodiscard]] std::vector<TomlReader> tables(std::string_view key);

  /// Call when everything has been read: throws a ConfigError for the first key that was not read.
  void finish() const;

  /// Throws a ConfigError for `key` (or for the table if there is no such key).
  [[noreturn]] void fail(std::string_view key, std::string_view reason) const;
  /// Returns "file:line: [table] key", for errors that appear only on the running line.
  [[nodiscard]] std::string place(std::string_view key) const;

 private:
  std::unique_ptr<Table> table_;
};

}  // namespace driveline::runtime
