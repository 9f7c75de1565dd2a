#include <array>
#include <optional>
#include <utility>

#include "csv_rows.hpp"
#include "driveline/trajectory/cam.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::string_view kCamHeader = "master[rad],slave[mm]";

/// Meaning of a column of a cam, in the order in which their values must be known.
enum class CamColumn : std::uint8_t { kMaster, kSlave, kSlope, kCurvature };
constexpr std::size_t kCamColumns = 4;

std::string_view column_text(CamColumn column) {
  constexpr std::array<std::string_view, kCamColumns> kNames{"positions of the master", "positions of the slave",
                                                             "slopes of the slave", "curvatures of the slave"};
  return kNames[static_cast<std::size_t>(column)];
}

/// Unit of a column: a position unit, or a quotient of two.
struct CamUnit {
  const PositionUnit* of = nullptr;
  const PositionUnit* by = nullptr;  // null: a position
  bool squared = false;
};

std::optional<CamUnit> find_cam_unit(std::string_view name) {
  CamUnit unit;
  const auto slash = name.find('/');
  unit.of = find_position_unit(name.substr(0, slash));
  if (slash == std::string_view::npos) return unit.of != nullptr ? std::optional(unit) : std::nullopt;
  auto by = name.substr(slash + 1);
  unit.squared = by.ends_with("^2");
  if (unit.squared) by.remove_suffix(2);
  unit.by = find_position_unit(by);
  return unit.of != nullptr && unit.by != nullptr ? std::optional(unit) : std::nullopt;
}

struct CamHeading {
  CsvPlace place{};
  CamUnit unit{};
  CamColumn holds = CamColumn::kMaster;
};

class CamParser {
 public:
  CamParser(std::string_view text, std::string_view name) : rows_(text, name) { table_.file = name; }

  tl::expected<CamTable, PathError> parse() {
    if (!rows_.next()) return rows_.refuse({1, 0}, "the file has no header row such as " + std::string(kCamHeader));
    if (auto header = read_header(); !header) return tl::unexpected(std::move(header.error()));
    while (rows_.next()) {
      if (auto row = read_row(); !row) return tl::unexpected(std::move(row.error()));
    }
    return std::move(table_);
  }

 private:
  tl::expected<void, PathError> read_header() {
    if (rows_.has_foreign_separator())
      return rows_.refuse({rows_.line(), 0}, std::string(kCsvSeparator) + ": " + std::string(kCamHeader));
    for (const auto& field : rows_.fields()) {
      if (auto heading = read_heading(field); !heading) return heading;
    }
    for (const auto needed : {CamColumn::kMaster, CamColumn::kSlave}) {
      if (find(needed) == nullptr) {
        return rows_.refuse({rows_.line(), 0}, "the header has no " + std::string(column_text(needed)) +
                                                   "; it must be such as " + std::string(kCamHeader));
      }
    }
    return check_derivatives();
  }

  tl::expected<void, PathError> read_heading(const CsvField& field) {
    const CsvPlace place{rows_.line(), field.column};
    const auto bracket = field.text.find('[');
    if (bracket == std::string_view::npos || field.text.back() != ']')
      return rows_.refuse(place, "column " + in_quotes(field.text) + " must be a name and a unit such as master[rad]");
    const auto name = csv_trimmed(field.text.substr(0, bracket));
    const auto unit_name = csv_trimmed(field.text.substr(bracket + 1, field.text.size() - bracket - 2));
    const auto unit = find_cam_unit(unit_name);
    if (!unit) {
      return rows_.refuse(place, "unknown unit " + in_quotes(unit_name) + " of column " + in_quotes(name) +
                                     "; expected rad, deg, rev, m, mm or um, for slopes a quotient such as mm/deg, "
                                     "for curvatures mm/deg^2");
    }
    const bool master = name == "master" && unit->by == nullptr;
    if (!master && name != "slave")
      return rows_.refuse(place,
                          "column " + in_quotes(field.text) + " is unknown; a cam has master[...] and slave[...]");
    const auto holds = master                ? CamColumn::kMaster
                       : unit->by == nullptr ? CamColumn::kSlave
                       : unit->squared       ? CamColumn::kCurvature
                                             : CamColumn::kSlope;
    if (find(holds) != nullptr) return rows_.refuse(place, "the " + std::string(column_text(holds)) + " appear twice");
    headings_.push_back({place, *unit, holds});
    if (holds == CamColumn::kMaster) table_.master_unit = unit->of;
    if (holds == CamColumn::kSlave) table_.slave_unit = unit->of;
    return {};
  }

  const CamHeading* find(CamColumn holds) const {
    for (const auto& heading : headings_) {
      if (heading.holds == holds) return &heading;
    }
    return nullptr;
  }

  tl::expected<void, PathError> check_derivatives() {
    for (const auto holds : {CamColumn::kSlope, CamColumn::kCurvature}) {
      const auto* const heading = find(holds);
      if (heading == nullptr) continue;
      if (heading->unit.of->kind != table_.slave_unit->kind || heading->unit.by->kind != table_.master_unit->kind) {
        return rows_.refuse(heading->place, "the " + std::string(column_text(holds)) + " must fit a slave in " +
                                                std::string(table_.slave_unit->name) + " and a master in " +
                                                std::string(table_.master_unit->name));
      }
    }
    table_.gives_slope = find(CamColumn::kSlope) != nullptr;
    table_.gives_curvature = find(CamColumn::kCurvature) != nullptr;
    if (!table_.gives_curvature || table_.gives_slope) return {};
    return rows_.refuse(find(CamColumn::kCurvature)->place, "the curvatures of the slave need slopes as well");
  }

  tl::expected<void, PathError> read_row() {
    const auto& fields = rows_.fields();
    if (fields.size() != headings_.size()) {
      const bool foreign = fields.size() > headings_.size() || rows_.has_foreign_separator();
      return rows_.refuse({rows_.line(), 0}, "expected " + std::to_string(headings_.size()) +
                                                 " fields as in the header, found " + std::to_string(fields.size()) +
                                                 (foreign ? "; " + std::string(kCsvSeparator) : ""));
    }
    CamPoint point;
    point.line = rows_.line();
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto value = rows_.number(fields[i]);
      if (!value) return tl::unexpected(value.error());
      take(point, headings_[i], *value);
    }
    if (table_.points.size() == kMaxCamPoints)
      return rows_.refuse({rows_.line(), 0}, "a cam has at most " + std::to_string(kMaxCamPoints) + " points");
    table_.points.push_back(point);
    return {};
  }

  static void take(CamPoint& point, const CamHeading& heading, double value) {
    const auto& [of, by, squared] = heading.unit;
    const double in_si = of->to_si(value);
    switch (heading.holds) {
      case CamColumn::kMaster:
        point.master = in_si;
        return;
      case CamColumn::kSlave:
        point.slave = in_si;
        return;
      case CamColumn::kSlope:
        point.slope = by->from_si(in_si);
        return;
      case CamColumn::kCurvature:
        point.curvature = by->from_si(by->from_si(in_si));
        return;
    }
  }

  CsvRows rows_;
  std::vector<CamHeading> headings_;
  CamTable table_;
};

}  // namespace

tl::expected<CamTable, PathError> parse_cam_csv(std::string_view text, std::string_view name) {
  return CamParser(text, name).parse();
}

tl::expected<CamTable, PathError> load_cam_table(const std::filesystem::path& file) {
  const auto text = read_csv_text(file);
  if (!text) return tl::unexpected(text.error());
  return parse_cam_csv(*text, file.string());
}

}  // namespace driveline::trajectory
