#include "axes/axis_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/motion/cia402/error_code.hpp"
#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

/// Name of the mode in 6061h, which is 0 until a mode is set.
std::string_view mode_text(std::int8_t mode) {
  return mode == 0 ? "-" : to_text(static_cast<motion::cia402::Mode>(mode));
}

std::string number(const nlohmann::json& axis, std::string_view key, std::string_view unit) {
  const auto value = axis.find(key);
  return value == axis.end() ? "-" : fmt::format("{:.6g} {}", value->get<double>(), unit);
}

/// The position within the modulo, in [0, modulo), of a position that may exceed it.
double within(double position, double modulo) {
  const double rest = std::fmod(position, modulo);
  const double place = rest < 0.0 ? rest + modulo : rest;
  // Rounding below zero would give a whole modulo.
  return place < modulo ? place : 0.0;
}

/// The position as "372.5 deg"; for an axis with a modulo "372.5 deg (12.5 of 360 deg)".
std::string place_text(const nlohmann::json& axis) {
  const auto unit = axis.at("unit").get<std::string>();
  auto place = number(axis, "position", unit);
  const auto modulo = axis.find("modulo_position");
  if (modulo == axis.end()) return place;
  return fmt::format("{} ({:.6g} of {})", place, modulo->get<double>(), number(axis, "modulo", unit));
}

/// State, master and master position of a coupling, then its phase and its losses of synchronism, if any.
std::string coupling_text(const nlohmann::json& coupling) {
  const auto unit = coupling.at("master_unit").get<std::string>();
  auto line = fmt::format("{}: master {} at {}", coupling.at("state").get<std::string>(),
                          coupling.at("master").get<std::string>(), number(coupling, "master_position", unit));
  if (const auto phase = coupling.at("phase").get<double>(); phase != 0.0)
    line += fmt::format(", phase {:.6g} {}", phase, unit);
  if (const auto losses = coupling.at("losses").get<std::uint32_t>(); losses != 0)
    line += fmt::format(", synchronism lost {} times", losses);
  return line;
}

std::string text(const nlohmann::json& axis, std::string_view key) {
  const auto value = axis.find(key);
  return value == axis.end() || value->get_ref<const std::string&>().empty() ? "-" : value->get<std::string>();
}

/// Cells of an axis in the table.
using AxisRow = std::array<std::string, 7>;
/// Columns of numbers are aligned to the right.
constexpr std::array kRight{false, false, true, true, true, false, true};

AxisRow row_of(const nlohmann::json& axis) {
  const auto unit = axis.at("unit").get<std::string>();
  const auto factor = axis.find("override");
  return {axis.at("name").get<std::string>(),
          text(axis, "state"),
          place_text(axis),
          number(axis, "velocity", unit + "/s"),
          number(axis, "torque", text(axis, "torque_unit")),
          text(axis, "mode"),
          factor == axis.end() ? "-" : fmt::format("{:.4g} %", 100.0 * factor->get<double>())};
}

using Widths = std::array<std::size_t, kRight.size()>;

/// Two spaces between columns, or one where the row does not fit into a terminal otherwise.
std::size_t gap_between(const Widths& widths) {
  const auto columns = std::accumulate(widths.begin(), widths.end(), std::size_t{0});
  return columns + 2 * (widths.size() - 1) <= kTextColumns ? 2 : 1;
}

std::string line_of(const AxisRow& row, const Widths& widths) {
  const std::string gap(gap_between(widths), ' ');
  std::string line;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) line += gap;
    line +=
        kRight.at(i) ? fmt::format("{:>{}}", row.at(i), widths.at(i)) : fmt::format("{:<{}}", row.at(i), widths.at(i));
  }
  while (line.ends_with(' ')) line.pop_back();
  return line + '\n';
}

/// A line per owner, "commanded by hand: x, y": the name of an owner is too long for a column.
std::string owners_lines(const nlohmann::json& axes) {
  std::vector<std::pair<std::string, std::string>> owners;
  for (const auto& axis : axes) {
    const auto& owner = axis.at("owner").get_ref<const std::string&>();
    auto found = std::find_if(owners.begin(), owners.end(), [&](const auto& one) { return one.first == owner; });
    if (found == owners.end()) found = owners.insert(owners.end(), {owner, {}});
    found->second += (found->second.empty() ? "" : ", ") + axis.at("name").get<std::string>();
  }
  std::string lines;
  for (const auto& [owner, names] : owners)
    lines += fmt::format("commanded by {}: {}\n", owner.empty() ? "nobody" : owner, names);
  return lines;
}

}  // namespace

nlohmann::json to_json(const runtime::CouplingStatus& coupling) {
  nlohmann::json document = {{"master", coupling.master}, {"state", std::string(runtime::to_text(coupling.state))}};
  if (coupling.state == trajectory::CouplingState::kIdle) return document;
  const auto& unit = coupling.master_unit;
  document["master_unit"] = std::string(unit.name);
  document["master_position"] = unit.from_si(coupling.master_position);
  document["phase"] = unit.from_si(coupling.phase);
  document["losses"] = coupling.losses;
  return document;
}

nlohmann::json to_json(const runtime::AxisStatus& status) {
  const auto& unit = status.axis.unit;
  nlohmann::json axis = {{"name", status.axis.name}, {"unit", std::string(unit.name)}, {"owner", status.owner}};
  if (!status.report) return axis;
  const auto& report = *status.report;
  axis["state"] = std::string(motion::to_text(report.state));
  axis["setpoint"] = unit.from_si(report.setpoint);
  axis["position"] = unit.from_si(report.position);
  if (const auto modulo = status.axis.modulo) {
    axis["modulo"] = unit.from_si(*modulo);
    axis["modulo_position"] = unit.from_si(within(report.position, *modulo));
  }
  axis["velocity"] = unit.from_si(report.velocity);
  axis["torque"] = report.torque;
  axis["torque_unit"] = unit.kind == trajectory::AxisKind::kLinear ? "N" : "Nm";
  axis["mode"] = std::string(mode_text(report.mode));
  axis["override"] = report.override_factor;
  if (status.coupling) axis["coupling"] = to_json(*status.coupling);
  if (report.recorded_request != 0) axis["recorded_position"] = unit.from_si(report.recorded_position);
  if (report.error == motion::AxisError::kNone) return axis;
  axis["error"] = std::string(motion::to_text(report.error));
  if (report.error_code != 0) axis["error_code"] = motion::cia402::error_text(report.error_code);
  return axis;
}

nlohmann::json owners_json(const runtime::AxisRequests& axis_requests) {
  auto rows = nlohmann::json::array();
  for (std::size_t axis = 0; axis < axis_requests.axes().size(); ++axis)
    rows.push_back({{"name", axis_requests.axes()[axis].name}, {"owner", axis_requests.status(axis).owner}});
  return rows;
}

std::string owners_text(const runtime::AxisRequests& axis_requests) {
  std::string lines;
  for (std::size_t axis = 0; axis < axis_requests.axes().size(); ++axis) {
    const auto owner = axis_requests.status(axis).owner;
    lines +=
        fmt::format("axis {} is commanded by {}\n", axis_requests.axes()[axis].name, owner.empty() ? "nobody" : owner);
  }
  return lines;
}

std::string axes_table(const nlohmann::json& axes) {
  std::vector<AxisRow> rows{{"axis", "state", "position", "velocity", "torque", "mode", "override"}};
  for (const auto& axis : axes) rows.push_back(row_of(axis));
  Widths widths{};
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths.at(i) = std::max(widths.at(i), row.at(i).size());
  }
  auto table = line_of(rows.front(), widths);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    table += line_of(rows.at(i + 1), widths);
    const auto& axis = axes.at(i);
    const auto add = [&](std::string_view text) { table += fmt::format("{:<{}}  {}\n", "", widths.front(), text); };
    if (axis.contains("coupling") && axis.at("coupling").contains("phase")) add(coupling_text(axis.at("coupling")));
    if (axis.contains("error")) {
      add(text(axis, "error") +
          (axis.contains("error_code") ? fmt::format(" ({})", text(axis, "error_code")) : std::string{}));
    }
  }
  return table + owners_lines(axes);
}

std::string axis_line(const nlohmann::json& axis) {
  if (!axis.contains("state")) return fmt::format("axis {}", axis.at("name").get<std::string>());
  return fmt::format("axis {}: {} at {}", axis.at("name").get<std::string>(), text(axis, "state"), place_text(axis));
}

std::string accepted_line(const nlohmann::json& axis) {
  return fmt::format("{}; accepted by the axis", axis_line(axis));
}

std::string motion_line(const nlohmann::json& axis) {
  if (!axis.contains("state")) return axis_line(axis);
  return fmt::format("{}, {}, {}", axis_line(axis), number(axis, "velocity", axis.at("unit").get<std::string>() + "/s"),
                     number(axis, "torque", text(axis, "torque_unit")));
}

std::string recorded_line(const nlohmann::json& axis) {
  return fmt::format("axis {}: recorded {}", axis.at("name").get<std::string>(),
                     number(axis, "recorded_position", axis.at("unit").get<std::string>()));
}

}  // namespace driveline::cli
