#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/path.hpp"

namespace driveline::trajectory {

/// Hint for text with another separator.
inline constexpr std::string_view kCsvSeparator = "the separator is a comma, and numbers have a decimal point";

/// Position in a file, counted from 1; 0: does not apply.
struct CsvPlace {
  std::size_t line = 0;
  std::size_t column = 0;
};

/// One field of a row.
struct CsvField {
  std::string_view text;  ///< without surrounding blanks
  std::size_t column;     ///< column of its first character, from 1
};

/// `text` without surrounding blanks.
[[nodiscard]] std::string_view csv_trimmed(std::string_view text);

/// Iterates over CSV text row by row; a row is a line that is neither blank nor a comment.
class CsvRows {
 public:
  /// Both arguments must outlive it; `name` is the file name in errors.
  CsvRows(std::string_view text, std::string_view name);

  /// Moves to the next row. Returns false if there is none.
  [[nodiscard]] bool next();
  /// Fields of the current row.
  [[nodiscard]] const std::vector<CsvField>& fields() const noexcept { return fields_; }
  /// Line number of the current row.
  [[nodiscard]] std::size_t line() const noexcept { return line_; }
  /// Whether semicolons or tabs separate the fields, as in spreadsheets with decimal commas.
  [[nodiscard]] bool has_foreign_separator() const;
  /// Parses a field of the current row as a finite number.
  [[nodiscard]] tl::expected<double, PathError> number(const CsvField& field) const;
  /// Creates an error at a position of this file.
  [[nodiscard]] tl::unexpected<PathError> refuse(CsvPlace place, std::string reason) const;

 private:
  std::string_view rest_;
  std::string_view name_;
  std::size_t line_ = 0;
  std::vector<CsvField> fields_;
};

/// Reads a text file of at most 128 MiB and 1,000,000 lines.
[[nodiscard]] tl::expected<std::string, PathError> read_csv_text(const std::filesystem::path& file);

}  // namespace driveline::trajectory
