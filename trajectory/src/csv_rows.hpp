#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/path.hpp"

namespace driveline::trajectory {

/// What is said of text that was written with another separator.
inline constexpr std::string_view kCsvSeparator = "the separator is a comma, and numbers have a decimal point";

/// Where something stands in a file; from 1, 0: does not apply.
struct CsvPlace {
  std::size_t line = 0;
  std::size_t column = 0;
};

/// One field of a row.
struct CsvField {
  std::string_view text;  ///< trimmed
  std::size_t column;     ///< of its first character, from 1
};

/// Without the blanks at its ends.
[[nodiscard]] std::string_view csv_trimmed(std::string_view text);

/// Walks through CSV text row by row; a row is a line that is neither blank nor a comment.
class CsvRows {
 public:
  /// Both must outlive it; `name` stands for the file in errors.
  CsvRows(std::string_view text, std::string_view name);

  /// To the next row. False: there is none.
  [[nodiscard]] bool next();
  /// Of the present row.
  [[nodiscard]] const std::vector<CsvField>& fields() const noexcept { return fields_; }
  /// Number of the present row's line.
  [[nodiscard]] std::size_t line() const noexcept { return line_; }
  /// Semicolons or tabs where the commas should be, as spreadsheets write them where the decimal point is a comma.
  [[nodiscard]] bool has_foreign_separator() const;
  /// A field of the present row as a finite number.
  [[nodiscard]] tl::expected<double, PathError> number(const CsvField& field) const;
  /// An error at a place of this file.
  [[nodiscard]] tl::unexpected<PathError> refuse(CsvPlace place, std::string reason) const;

 private:
  std::string_view rest_;
  std::string_view name_;
  std::size_t line_ = 0;
  std::vector<CsvField> fields_;
};

/// The text of a file of at most 128 MiB.
[[nodiscard]] tl::expected<std::string, PathError> read_csv_text(const std::filesystem::path& file);

}  // namespace driveline::trajectory
