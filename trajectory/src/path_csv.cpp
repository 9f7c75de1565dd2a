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

/// What a column holds.
enum class ColumnKind { kTime, kPosition, kVelocity, kAcceleration };

/// Unit of a column.
struct Unit {
  ColumnKind holds = ColumnKind::kTime;
  const PositionUnit* position = nullptr;  // of positions, and with /s and /s^2 of the others
  double per_second = 0.0;                 // of the time: units per second
};

std::optional<Unit> find_unit(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, double>, 3> kTimeUnits{{{"s", 1.0}, {"ms", 1e3}, {"us", 1e6}}};
  for (const auto& [time_unit, per_second] : kTimeUnits) {
    if (time_unit == name) {
      return Unit{ColumnKind::kTime, nullptr, per_second};
    }
  }
  ColumnKind holds = ColumnKind::kPosition;
  for (const auto& [suffix, derivative] :
       {std::pair{std::string_view("/s"), ColumnKind::kVelocity}, {"/s^2", ColumnKind::kAcceleration}}) {
    if (name.ends_with(suffix)) {
      name.remove_suffix(suffix.size());
      holds = derivative;
      break;
    }
  }
  const PositionUnit* const position = find_position_unit(name);
  return position == nullptr ? std::nullopt : std::optional(Unit{holds, position, 0.0});
}

/// "velocities".
std::string_view plural(ColumnKind holds) {
  return holds == ColumnKind::kVelocity ? "velocities" : "accelerations";
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

/// A column as the header row has it.
struct Heading {
  Place place;
  std::string_view name;
  std::string_view unit_name;
  Unit unit;
  std::size_t axis = 0;  // number of its axis; none for the time
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
      if (auto heading = read_heading(field); !heading) {
        return heading;
      }
    }
    for (Heading& heading : headings_) {
      if (auto taken = take(heading); !taken) {
        return taken;
      }
    }
    if (!has_time_) {
      return refuse({line_, 0}, "the header has no time column; one column must be time[s], time[ms] or time[us]");
    }
    if (headings_.size() < 2) {
      return refuse({line_, 0}, "the header names no axis beside the time");
    }
    return bind_derivatives();
  }

  tl::expected<void, PathError> read_heading(const Field& field) {
    const Place place{line_, field.column};
    const std::size_t bracket = field.text.find('[');
    if (bracket == std::string_view::npos || field.text.back() != ']') {
      return refuse(place, "column " + in_quotes(field.text) + " must be a name and a unit such as x[rad]");
    }
    const std::string_view name = trimmed(field.text.substr(0, bracket));
    const std::string_view unit_name = trimmed(field.text.substr(bracket + 1, field.text.size() - bracket - 2));
    const auto unit = find_unit(unit_name);
    if (!unit) {
      const bool is_rate = unit_name.find('/') != std::string_view::npos;
      return refuse(place, "unknown unit " + in_quotes(unit_name) + " of column " + in_quotes(name) +
                               "; expected s, ms, us, rad, deg, rev, m, mm or um" +
                               (is_rate ? ", with /s for velocities and /s^2 for accelerations" : ""));
    }
    headings_.push_back({place, name, unit_name, *unit});
    return {};
  }

  tl::expected<void, PathError> take(Heading& heading) {
    if (heading.name == "time") return take_time(heading);
    switch (heading.unit.holds) {
      case ColumnKind::kTime:
        return refuse(heading.place, "axis " + in_quotes(heading.name) +
                                         " must be in rad, deg, rev, m, mm or um, not in " +
                                         std::string(heading.unit_name) + "; the column of the time is called time");
      case ColumnKind::kPosition:
        return take_axis(heading);
      case ColumnKind::kVelocity:
      case ColumnKind::kAcceleration:
        break;
    }
    return {};
  }

  tl::expected<void, PathError> take_time(const Heading& heading) {
    if (heading.unit.holds != ColumnKind::kTime) {
      return refuse(heading.place, "the time column must be in s, ms or us, not in " + std::string(heading.unit_name));
    }
    if (has_time_) {
      return refuse(heading.place, "the time column appears twice");
    }
    has_time_ = true;
    return {};
  }

  bool gives(std::string_view name, ColumnKind holds) const {
    return std::any_of(headings_.begin(), headings_.end(),
                       [&](const Heading& heading) { return heading.name == name && heading.unit.holds == holds; });
  }

  tl::expected<void, PathError> take_axis(Heading& heading) {
    heading.axis = axes_++;
    PathAxis axis{std::string(heading.name), heading.unit.position->kind, heading.unit.position};
    axis.gives_velocity = gives(heading.name, ColumnKind::kVelocity);
    axis.gives_acceleration = gives(heading.name, ColumnKind::kAcceleration);
    if (auto added = builder_.add_axis(std::move(axis)); !added) {
      return refuse(heading.place, std::move(added.error().reason));
    }
    return {};
  }

  /// Finds the axes of the columns with velocities and accelerations, which may stand before that of the positions.
  tl::expected<void, PathError> bind_derivatives() {
    for (auto heading = headings_.begin(); heading != headings_.end(); ++heading) {
      const ColumnKind holds = heading->unit.holds;
      if (holds != ColumnKind::kVelocity && holds != ColumnKind::kAcceleration) continue;
      const std::string what = std::string("the ").append(plural(holds)) + " of axis " + in_quotes(heading->name);
      const auto find = [&](auto begin, auto end, ColumnKind wanted) {
        return std::find_if(begin, end, [&](const Heading& other) {
          return other.name == heading->name && other.unit.holds == wanted;
        });
      };
      const auto positions = find(headings_.begin(), headings_.end(), ColumnKind::kPosition);
      if (positions == headings_.end()) {
        return refuse(heading->place, "there are no positions for " + what);
      }
      if (find(headings_.begin(), heading, holds) != heading) {
        return refuse(heading->place, what + " appear twice");
      }
      if (heading->unit.position->kind != positions->unit.position->kind) {
        return refuse(heading->place, what + " must fit its positions in " + std::string(positions->unit_name) +
                                          ", not be in " + std::string(heading->unit_name));
      }
      heading->axis = positions->axis;
    }
    velocities_.resize(axes_);
    accelerations_.resize(axes_);
    positions_.resize(axes_);
    return {};
  }

  tl::expected<void, PathError> read_row() {
    if (fields_.size() != headings_.size()) {
      // Too many fields come from decimal commas, a single one from another separator.
      const bool foreign = fields_.size() > headings_.size() || has_foreign_separator();
      return refuse({line_, 0}, "expected " + std::to_string(headings_.size()) + " fields as in the header, found " +
                                    std::to_string(fields_.size()) + (foreign ? "; " + std::string(kSeparator) : ""));
    }
    double time_s = 0.0;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      const auto value = read_number(fields_[i]);
      if (!value) {
        return tl::unexpected(value.error());
      }
      const auto& [holds, position, per_second] = headings_[i].unit;
      if (holds == ColumnKind::kTime) {
        time_s = *value / per_second;
      } else {
        values_of(holds)[headings_[i].axis] = position->to_si(*value);
      }
    }
    if (auto added = builder_.add_point({time_s, positions_, velocities_, accelerations_}); !added) {
      return refuse({line_, 0}, std::move(added.error().reason));
    }
    return {};
  }

  std::vector<double>& values_of(ColumnKind holds) {
    return holds == ColumnKind::kVelocity       ? velocities_
           : holds == ColumnKind::kAcceleration ? accelerations_
                                                : positions_;
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
  std::vector<Heading> headings_;  // one per column
  bool has_time_ = false;
  std::size_t axes_ = 0;
  std::vector<double> positions_;  // of one point
  std::vector<double> velocities_;
  std::vector<double> accelerations_;
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
