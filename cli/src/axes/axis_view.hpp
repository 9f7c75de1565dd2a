#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "driveline/runtime/axes/axis_door.hpp"

namespace driveline::cli {

/// Name, unit, state, actual values and owner of an axis.
[[nodiscard]] nlohmann::json to_json(const runtime::AxisStatus& status);
/// Name and owner of every axis.
[[nodiscard]] nlohmann::json owners_json(const runtime::AxisDoor& door);
/// "axis x is commanded by path" or "axis x is commanded by nobody", a line for each axis.
[[nodiscard]] std::string owners_text(const runtime::AxisDoor& door);
/// A table of axes as the document of `axis all status` has them.
[[nodiscard]] std::string axes_table(const nlohmann::json& axes);
/// "axis x: Standstill at 90 deg", of an axis in that document.
[[nodiscard]] std::string axis_line(const nlohmann::json& axis);
/// The same with velocity and torque: "axis x: ContinuousMotion at 90 deg, 30 deg/s, 0.5 Nm".
[[nodiscard]] std::string motion_line(const nlohmann::json& axis);
/// "axis x: recorded 90 deg": where its touch probe has last had an event.
[[nodiscard]] std::string recorded_line(const nlohmann::json& axis);

}  // namespace driveline::cli
