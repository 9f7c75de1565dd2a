#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// An error in a file. The readers throw it, and load_line_config() returns it as the error of the file; code in
/// between (a DeviceFamily, say) lets it pass.
struct ConfigError {
  Error error;  ///< with file and line
};

/// Typed access to one table of a TOML file. It knows its place in the file and which keys were read. A key that is
/// missing, has another type or is out of range throws a ConfigError: "file:line: [table] key: reason". Ordinary
/// threads only.
class TomlReader {
 public:
  struct Table;  ///< of the file, as its parser has it
  /// Made by read_toml_table(); sub-tables by table().
  explicit TomlReader(std::unique_ptr<Table> table);
  ~TomlReader();
  /// A moved-from reader can only be destroyed or assigned to.
  TomlReader(TomlReader&& other) noexcept;
  TomlReader& operator=(TomlReader&& other) noexcept;

  /// The key is there, with a value of any type.
  [[nodiscard]] bool has(std::string_view key);
  /// Whether the value of this key is a string.
  [[nodiscard]] bool is_text(std::string_view key);
  /// A string.
  [[nodiscard]] std::string text(std::string_view key);
  /// A string; `fallback` when it is left out.
  [[nodiscard]] std::string text_or(std::string_view key, std::string fallback);
  /// True or false; `fallback` when it is left out.
  [[nodiscard]] bool boolean_or(std::string_view key, bool fallback);
  /// A number within minimum..maximum; integers are accepted for numbers.
  [[nodiscard]] double number(std::string_view key, double minimum, double maximum);
  /// The same; `fallback` when it is left out.
  [[nodiscard]] double number_or(std::string_view key, double fallback, double minimum, double maximum);
  /// An integer within minimum..maximum.
  [[nodiscard]] std::int64_t integer(std::string_view key, std::int64_t minimum, std::int64_t maximum);
  /// The same; `fallback` when it is left out.
  [[nodiscard]] std::int64_t integer_or(std::string_view key, std::int64_t fallback, std::int64_t minimum,
                                        std::int64_t maximum);
  /// The value of a string, or a number as text.
  [[nodiscard]] std::string scalar_text(std::string_view key);
  /// An array of numbers within minimum..maximum.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, double minimum, double maximum);
  /// An array of strings; `fallback` when it is left out.
  [[nodiscard]] std::vector<std::string> texts_or(std::string_view key, std::vector<std::string> fallback);
  /// The position of the value in `choices`; `fallback` when it is left out.
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
  /// "file:line: [table] key", for errors that show only once the line is there.
  [[nodiscard]] std::string place(std::string_view key) const;

 private:
  std::unique_ptr<Table> table_;
};

}  // namespace driveline::runtime
