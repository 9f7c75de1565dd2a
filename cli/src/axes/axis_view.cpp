#include "axes/axis_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "driveline/ecat_master/cia402/cia402.hpp"
#include "driveline/ecat_master/cia402/error_code.hpp"

namespace driveline::cli {
namespace {

/// 6061h is 0 until a mode is set.
std::string_view mode_text(std::int8_t mode) {
  return mode == 0 ? "-" : to_text(static_cast<ecat_master::cia402::Mode>(mode));
}

std::string number(const nlohmann::json& axis, std::string_view key, std::string_view unit) {
  const auto value = axis.find(key);
  return value == axis.end() ? "-" : fmt::format("{:.6g} {}", value->get<double>(), unit);
}

std::string text(const nlohmann::json& axis, std::string_view key) {
  const auto value = axis.find(key);
  return value == axis.end() || value->get_ref<const std::string&>().empty() ? "-" : value->get<std::string>();
}

}  // namespace

nlohmann::json to_json(const runtime::AxisStatus& status) {
  const auto& unit = status.axis.unit;
  nlohmann::json axis = {{"name", status.axis.name}, {"unit", std::string(unit.name)}, {"owner", status.owner}};
  if (!status.report) return axis;
  const auto& report = *status.report;
  axis["state"] = std::string(ecat_master::to_text(report.state));
  axis["setpoint"] = unit.from_si(report.setpoint);
  axis["position"] = unit.from_si(report.position);
  axis["velocity"] = unit.from_si(report.velocity);
  axis["torque"] = report.torque;
  axis["torque_unit"] = unit.kind == trajectory::AxisKind::kLinear ? "N" : "Nm";
  axis["mode"] = std::string(mode_text(report.mode));
  axis["override"] = report.override_factor;
  if (report.recorded_request != 0) axis["recorded_position"] = unit.from_si(report.recorded_position);
  if (report.error == ecat_master::AxisError::kNone) return axis;
  axis["error"] = std::string(ecat_master::to_text(report.error));
  if (report.error_code != 0) axis["error_code"] = ecat_master::cia402::error_text(report.error_code);
  return axis;
}

std::string axes_table(const nlohmann::json& axes) {
  std::size_t widest = 4;
  for (const auto& axis : axes) widest = std::max(widest, axis.at("name").get_ref<const std::string&>().size());
  auto table = fmt::format("{:<{}}  {:<20}{:>16}{:>18}{:>12}  {:<5}{:>9}  {}\n", "axis", widest, "state", "position",
                           "velocity", "torque", "mode", "override", "commanded by");
  for (const auto& axis : axes) {
    const auto unit = axis.at("unit").get<std::string>();
    const auto override_factor = axis.find("override");
    table += fmt::format(
        "{:<{}}  {:<20}{:>16}{:>18}{:>12}  {:<5}{:>9}  {}\n", axis.at("name").get<std::string>(), widest,
        text(axis, "state"), number(axis, "position", unit), number(axis, "velocity", unit + "/s"),
        number(axis, "torque", text(axis, "torque_unit")), text(axis, "mode"),
        override_factor == axis.end() ? "-" : fmt::format("{:.4g} %", 100.0 * override_factor->get<double>()),
        text(axis, "owner"));
    if (axis.contains("error")) {
      table += fmt::format("{:<{}}  {}{}\n", "", widest, text(axis, "error"),
                           axis.contains("error_code") ? fmt::format(" ({})", text(axis, "error_code")) : "");
    }
  }
  return table;
}

std::string axis_line(const nlohmann::json& axis) {
  if (!axis.contains("state")) return fmt::format("axis {}", axis.at("name").get<std::string>());
  return fmt::format("axis {}: {} at {}", axis.at("name").get<std::string>(), text(axis, "state"),
                     number(axis, "position", axis.at("unit").get<std::string>()));
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
