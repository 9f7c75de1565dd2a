#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "csv_rows.hpp"
#include "driveline/trajectory/path.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

/// Meaning of a column.
enum class ColumnKind { kTime, kPosition, kVelocity, kAcceleration };

/// Unit of a column.
struct Unit {
  ColumnKind holds = ColumnKind::kTime;
  const PositionUnit* position = nullptr;  // unit of positions, with /s and /s^2 for the derivatives
  double per_second = 0.0;                 // time unit: units per second
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

/// Returns "velocities" or "accelerations".
std::string_view plural(ColumnKind holds) {
  return holds == ColumnKind::kVelocity ? "velocities" : "accelerations";
}

/// A column as given in the header row.
struct Heading {
  CsvPlace place;
  std::string_view name;
  std::string_view unit_name;
  Unit unit;
  std::size_t axis = 0;  // index of its axis; unused for the time
};

// Parses the text row by row; a row is a line that is neither blank nor a comment.
class CsvParser {
 public:
  CsvParser(std::string_view text, std::string_view name, bool needs_time)
      : rows_(text, name), needs_time_(needs_time) {}

  tl::expected<Path, PathError> parse() {
    if (!rows_.next()) {
      return refuse({1, 0}, "the file has no header row such as time[s],x[rad]");
    }
    if (auto header = read_header(); !header) {
      return tl::unexpected(std::move(header.error()));
    }
    while (rows_.next()) {
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
  tl::unexpected<PathError> refuse(CsvPlace place, std::string reason) const {
    return rows_.refuse(place, std::move(reason));
  }

  tl::expected<void, PathError> read_header() {
    if (rows_.has_foreign_separator()) {
      return refuse({rows_.line(), 0}, std::string(kCsvSeparator) + ": time[s],x[rad]");
    }
    bool has_unit = false;
    for (const CsvField& field : rows_.fields()) {
      has_unit = has_unit || field.text.find('[') != std::string_view::npos;
    }
    if (!has_unit) {
      return refuse({rows_.line(), rows_.fields().front().column},
                    "expected a header row such as time[s],x[rad], found " + in_quotes(rows_.fields().front().text));
    }
    for (const CsvField& field : rows_.fields()) {
      if (auto heading = read_heading(field); !heading) {
        return heading;
      }
    }
    for (Heading& heading : headings_) {
      if (auto taken = take(heading); !taken) {
        return taken;
      }
    }
    if (!has_time_ && needs_time_) {
      return refuse({rows_.line(), 0},
                    "the header has no time column; one column must be time[s], time[ms] or time[us]");
    }
    if (has_time_ && headings_.size() < 2) {
      return refuse({rows_.line(), 0}, "the header has a time column but no axis");
    }
    return bind_derivatives();
  }

  tl::expected<void, PathError> read_heading(const CsvField& field) {
    const CsvPlace place{rows_.line(), field.column};
    const std::size_t bracket = field.text.find('[');
    if (bracket == std::string_view::npos || field.text.back() != ']') {
      return refuse(place, "column " + in_quotes(field.text) + " must be a name and a unit such as x[rad]");
    }
    const std::string_view name = csv_trimmed(field.text.substr(0, bracket));
    const std::string_view unit_name = csv_trimmed(field.text.substr(bracket + 1, field.text.size() - bracket - 2));
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

  /// Finds the axes of the columns with velocities and accelerations, which may precede the column of the positions.
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
    if (rows_.fields().size() != headings_.size()) {
      // Too many fields result from decimal commas, a single field from another separator.
      const bool foreign = rows_.fields().size() > headings_.size() || rows_.has_foreign_separator();
      return refuse({rows_.line(), 0}, "expected " + std::to_string(headings_.size()) +
                                           " fields as in the header, found " + std::to_string(rows_.fields().size()) +
                                           (foreign ? "; " + std::string(kCsvSeparator) : ""));
    }
    constexpr double kStepS = 1e-3;
    double time_s = static_cast<double>(points_++) * kStepS;
    const auto& fields = rows_.fields();
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto value = rows_.number(fields[i]);
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
      return refuse({rows_.line(), 0}, std::move(added.error().reason));
    }
    return {};
  }

  std::vector<double>& values_of(ColumnKind holds) {
    return holds == ColumnKind::kVelocity       ? velocities_
           : holds == ColumnKind::kAcceleration ? accelerations_
                                                : positions_;
  }

  CsvRows rows_;
  std::vector<Heading> headings_;  // one per column
  bool needs_time_;
  bool has_time_ = false;
  std::size_t points_ = 0;
  std::size_t axes_ = 0;
  std::vector<double> positions_;  // positions of one point
  std::vector<double> velocities_;
  std::vector<double> accelerations_;
  PathBuilder builder_;
};

}  // namespace

tl::expected<Path, PathError> parse_path_csv(std::string_view text, std::string_view name) {
  return CsvParser(text, name, true).parse();
}

tl::expected<Path, PathError> parse_points_csv(std::string_view text, std::string_view name) {
  return CsvParser(text, name, false).parse();
}

tl::expected<Path, PathError> load_path(const std::filesystem::path& file) {
  const auto text = read_csv_text(file);
  if (!text) {
    return tl::unexpected(text.error());
  }
  return parse_path_csv(*text, file.string());
}

tl::expected<Path, PathError> load_points(const std::filesystem::path& file) {
  const auto text = read_csv_text(file);
  if (!text) return tl::unexpected(text.error());
  return parse_points_csv(*text, file.string());
}

}  // namespace driveline::trajectory
