#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "driveline/trajectory/path.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::string_view kBlanks = " \t";
constexpr std::string_view kSeparator = "the separator is a comma, and numbers have a decimal point";
constexpr std::size_t kMaxFileBytes = std::size_t{128} << 20;

/// Unit of a column.
struct Unit {
  const PositionUnit* position = nullptr;  // null: the column is the time, in
  double per_second = 0.0;                 // units per second
};

std::optional<Unit> find_unit(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, double>, 3> kTimeUnits{{{"s", 1.0}, {"ms", 1e3}, {"us", 1e6}}};
  for (const auto& [time_unit, per_second] : kTimeUnits) {
    if (time_unit == name) {
      return Unit{nullptr, per_second};
    }
  }
  const PositionUnit* const position = find_position_unit(name);
  return position == nullptr ? std::nullopt : std::optional(Unit{position, 0.0});
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

struct Field {
  std::string_view text;  // trimmed
  std::size_t column;     // of its first character, from 1
};

void split(std::string_view line, std::vector<Field>& fields) {
  fields.clear();
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = line.find(',', begin);
    const std::string_view raw = line.substr(begin, comma == std::string_view::npos ? comma : comma - begin);
    const std::size_t lead = raw.find_first_not_of(kBlanks);
    fields.push_back({trimmed(raw), begin + 1 + (lead == std::string_view::npos ? 0 : lead)});
    if (comma == std::string_view::npos) {
      return;
    }
    begin = comma + 1;
  }
}

struct Place {
  std::size_t line = 0;
  std::size_t column = 0;
};

// Walks through the text row by row; a row is a line that is neither blank nor a comment.
class CsvParser {
 public:
  CsvParser(std::string_view text, std::string_view name) : rest_(text), name_(name) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (rest_.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
      rest_.remove_prefix(kByteOrderMark.size());
    }
  }

  tl::expected<Path, PathError> parse() {
    if (!next_row()) {
      return refuse({1, 0}, "the file has no header row such as time[s],x[rad]");
    }
    if (auto header = read_header(); !header) {
      return tl::unexpected(std::move(header.error()));
    }
    while (next_row()) {
      if (auto row = read_row(); !row) {
        return tl::unexpected(std::move(row.error()));
      }
    }
    auto path = builder_.build();
    if (!path) {
      return refuse({}, std::move(path.error().reason));
    }
    return path;
  }

 private:
  tl::unexpected<PathError> refuse(Place place, std::string reason) const {
    return tl::unexpected(PathError{std::string(name_), place.line, place.column, std::move(reason)});
  }

  bool next_row() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      std::string_view line = rest_.substr(0, end);
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++line_;
      if (!line.empty() && line.back() == '\r') {
        line.remove_suffix(1);
      }
      const std::string_view content = trimmed(line);
      if (!content.empty() && content.front() != '#') {
        split(line, fields_);
        return true;
      }
    }
    return false;
  }

  /// Semicolons or tabs where the commas should be, as spreadsheets write them where the decimal point is a comma.
  bool has_foreign_separator() const {
    return std::any_of(fields_.begin(), fields_.end(),
                       [](const Field& field) { return field.text.find_first_of(";\t") != std::string_view::npos; });
  }

  tl::expected<void, PathError> read_header() {
    if (has_foreign_separator()) {
      return refuse({line_, 0}, std::string(kSeparator) + ": time[s],x[rad]");
    }
    bool has_unit = false;
    for (const Field& field : fields_) {
      has_unit = has_unit || field.text.find('[') != std::string_view::npos;
    }
    if (!has_unit) {
      return refuse({line_, fields_.front().column},
                    "expected a header row such as time[s],x[rad], found " + in_quotes(fields_.front().text));
    }
    for (const Field& field : fields_) {
      if (auto column = read_column(field); !column) {
        return column;
      }
    }
    if (!time_index_) {
      return refuse({line_, 0}, "the header has no time column; one column must be time[s], time[ms] or time[us]");
    }
    if (units_.size() < 2) {
      return refuse({line_, 0}, "the header names no axis beside the time");
    }
    return {};
  }

  tl::expected<void, PathError> read_column(const Field& field) {
    const Place place{line_, field.column};
    const std::size_t bracket = field.text.find('[');
    if (bracket == std::string_view::npos || field.text.back() != ']') {
      return refuse(place, "column " + in_quotes(field.text) + " must be a name and a unit such as x[rad]");
    }
    const std::string_view name = trimmed(field.text.substr(0, bracket));
    const std::string_view unit_name = trimmed(field.text.substr(bracket + 1, field.text.size() - bracket - 2));
    const auto unit = find_unit(unit_name);
    if (!unit) {
      return refuse(place, "unknown unit " + in_quotes(unit_name) + " of column " + in_quotes(name) +
                               "; expected s, ms, us, rad, deg, rev, m, mm or um");
    }
    units_.push_back(*unit);
    return name == "time" ? take_time(place, *unit) : take_axis(place, name, *unit, unit_name);
  }

  tl::expected<void, PathError> take_time(Place place, const Unit& unit) {
    if (unit.position != nullptr) {
      return refuse(place, "the time column must be in s, ms or us, not in " + std::string(unit.position->name));
    }
    if (time_index_) {
      return refuse(place, "the time column appears twice");
    }
    time_index_ = units_.size() - 1;
    return {};
  }

  tl::expected<void, PathError> take_axis(Place place, std::string_view name, const Unit& unit,
                                          std::string_view unit_name) {
    if (unit.position == nullptr) {
      return refuse(place, "axis " + in_quotes(name) + " must be in rad, deg, rev, m, mm or um, not in " +
                               std::string(unit_name) + "; the column of the time is called time");
    }
    if (auto added = builder_.add_axis({std::string(name), unit.position->kind, unit.position}); !added) {
      return refuse(place, std::move(added.error().reason));
    }
    return {};
  }

  tl::expected<void, PathError> read_row() {
    if (fields_.size() != units_.size()) {
      // Too many fields come from decimal commas, a single one from another separator.
      const bool foreign = fields_.size() > units_.size() || has_foreign_separator();
      return refuse({line_, 0}, "expected " + std::to_string(units_.size()) + " fields as in the header, found " +
                                    std::to_string(fields_.size()) + (foreign ? "; " + std::string(kSeparator) : ""));
    }
    double time_s = 0.0;
    positions_.clear();
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      const auto value = read_number(fields_[i]);
      if (!value) {
        return tl::unexpected(value.error());
      }
      if (i == *time_index_) {
        time_s = *value / units_[i].per_second;
      } else {
        positions_.push_back(units_[i].position->to_si(*value));
      }
    }
    if (auto added = builder_.add_point(time_s, positions_); !added) {
      return refuse({line_, 0}, std::move(added.error().reason));
    }
    return {};
  }

  tl::expected<double, PathError> read_number(const Field& field) const {
    const Place place{line_, field.column};
    double value = 0.0;
    const char* const end = field.text.data() + field.text.size();
    const auto [stop, fault] = std::from_chars(field.text.data(), end, value);
    if (fault == std::errc::invalid_argument || stop != end) {
      return refuse(place, in_quotes(field.text) + " is not a number");
    }
    if (fault == std::errc::result_out_of_range) {
      return refuse(place, in_quotes(field.text) + " is beyond the range of a double");
    }
    if (!std::isfinite(value)) {
      return refuse(place, in_quotes(field.text) + " is not a finite number");
    }
    return value;
  }

  std::string_view rest_;
  std::string_view name_;
  std::size_t line_ = 0;
  std::vector<Field> fields_;
  std::vector<Unit> units_;  // one per column
  std::optional<std::size_t> time_index_;
  std::vector<double> positions_;
  PathBuilder builder_;
};

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

tl::expected<std::string, PathError> read_text(const std::filesystem::path& file) {
  const auto refuse = [&file](std::string reason) {
    return tl::unexpected(PathError{file.string(), 0, 0, std::move(reason)});
  };
  const auto unreadable = [&refuse] { return refuse("cannot be read: " + std::generic_category().message(errno)); };
  const File stream(std::fopen(file.c_str(), "rb"), &std::fclose);
  if (!stream) {
    return unreadable();
  }
  std::string text;
  std::vector<char> block(std::size_t{1} << 16);
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), stream.get())) {
    text.append(block.data(), count);
    if (text.size() > kMaxFileBytes) {
      return refuse("is larger than 128 MiB");
    }
  }
  if (std::ferror(stream.get()) != 0) {
    return unreadable();
  }
  return text;
}

}  // namespace

tl::expected<Path, PathError> parse_path_csv(std::string_view text, std::string_view name) {
  return CsvParser(text, name).parse();
}

tl::expected<Path, PathError> load_path(const std::filesystem::path& file) {
  const auto text = read_text(file);
  if (!text) {
    return tl::unexpected(text.error());
  }
  return parse_path_csv(*text, file.string());
}

}  // namespace driveline::trajectory
