#include <array>
#include <optional>
#include <utility>

#include "csv_rows.hpp"
#include "driveline/trajectory/position_correction.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::string_view kCorrectionHeader = "position[mm],correction[um]";
constexpr std::array<std::string_view, 3> kCorrectionColumns{"position", "correction", "backward"};

class CorrectionParser {
 public:
  CorrectionParser(std::string_view text, std::string_view name) : rows_(text, name) { table_.file = name; }

  tl::expected<CorrectionTable, PathError> parse() {
    if (!rows_.next())
      return rows_.refuse({1, 0}, "the file has no header row such as " + std::string(kCorrectionHeader));
    if (auto header = read_header(); !header) return tl::unexpected(std::move(header.error()));
    while (rows_.next()) {
      if (auto row = read_row(); !row) return tl::unexpected(std::move(row.error()));
    }
    return std::move(table_);
  }

 private:
  tl::expected<void, PathError> read_header() {
    const auto& fields = rows_.fields();
    if (rows_.has_foreign_separator())
      return rows_.refuse({rows_.line(), 0}, std::string(kCsvSeparator) + ": " + std::string(kCorrectionHeader));
    if (fields.size() < 2 || fields.size() > kCorrectionColumns.size()) {
      return rows_.refuse({rows_.line(), 0}, "the header has " + std::to_string(fields.size()) +
                                                 " columns; it must be such as " + std::string(kCorrectionHeader) +
                                                 ", optionally followed by backward[um]");
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (auto heading = read_heading(fields[i], i); !heading) return heading;
    }
    table_.unit = units_.front();
    table_.kind = units_.front()->kind;
    return {};
  }

  tl::expected<void, PathError> read_heading(const CsvField& field, std::size_t number) {
    const CsvPlace place{rows_.line(), field.column};
    const auto bracket = field.text.find('[');
    const bool whole = bracket != std::string_view::npos && field.text.back() == ']';
    if (!whole || csv_trimmed(field.text.substr(0, bracket)) != kCorrectionColumns.at(number)) {
      return rows_.refuse(place, "column " + in_quotes(field.text) + " must be " +
                                     std::string(kCorrectionColumns.at(number)) + " with its unit, such as in " +
                                     std::string(kCorrectionHeader));
    }
    const auto unit_name = csv_trimmed(field.text.substr(bracket + 1, field.text.size() - bracket - 2));
    const auto* const unit = find_position_unit(unit_name);
    if (unit == nullptr)
      return rows_.refuse(place, "unknown unit " + in_quotes(unit_name) + "; expected rad, deg, rev, m, mm or um");
    if (!units_.empty() && unit->kind != units_.front()->kind) {
      return rows_.refuse(place, "the unit " + std::string(unit->name) + " does not fit positions in " +
                                     std::string(units_.front()->name));
    }
    units_.push_back(unit);
    return {};
  }

  tl::expected<void, PathError> read_row() {
    const auto& fields = rows_.fields();
    if (fields.size() != units_.size()) {
      return rows_.refuse({rows_.line(), 0}, "expected " + std::to_string(units_.size()) +
                                                 " fields as in the header, found " + std::to_string(fields.size()) +
                                                 (rows_.has_foreign_separator() || fields.size() > units_.size()
                                                      ? "; " + std::string(kCsvSeparator)
                                                      : ""));
    }
    std::array<double, kCorrectionColumns.size()> values{};
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto value = rows_.number(fields[i]);
      if (!value) return tl::unexpected(value.error());
      values.at(i) = units_[i]->to_si(*value);
    }
    const auto& [position, forward, backward] = values;
    if (table_.points.size() == kMaxCamPoints)
      return rows_.refuse({rows_.line(), 0}, "a table has at most " + std::to_string(kMaxCamPoints) + " points");
    table_.points.push_back({position, forward, units_.size() == values.size() ? backward : forward, rows_.line()});
    return {};
  }

  CsvRows rows_;
  std::vector<const PositionUnit*> units_;
  CorrectionTable table_;
};

}  // namespace

tl::expected<CorrectionTable, PathError> parse_correction_csv(std::string_view text, std::string_view name) {
  return CorrectionParser(text, name).parse();
}

tl::expected<CorrectionTable, PathError> load_correction_table(const std::filesystem::path& file) {
  const auto text = read_csv_text(file);
  if (!text) return tl::unexpected(text.error());
  return parse_correction_csv(*text, file.string());
}

}  // namespace driveline::trajectory
