#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "driveline/runtime/axes/axis_requests.hpp"

namespace driveline::cli {

/// Name, unit, state, actual values and owner of an axis.
[[nodiscard]] nlohmann::json to_json(const runtime::AxisStatus& status);
/// Name and owner of every axis.
[[nodiscard]] nlohmann::json owners_json(const runtime::AxisRequests& axis_requests);
/// "axis x is commanded by path" or "axis x is commanded by nobody", one line per axis.
[[nodiscard]] std::string owners_text(const runtime::AxisRequests& axis_requests);
/// A table of the axes in the document of `axis all status`.
[[nodiscard]] std::string axes_table(const nlohmann::json& axes);
/// "axis x: Standstill at 90 deg" for an axis of that document.
[[nodiscard]] std::string axis_line(const nlohmann::json& axis);
/// The same for a request that the axis has accepted: "axis x: DiscreteMotion at 90 deg; accepted by the axis".
[[nodiscard]] std::string accepted_line(const nlohmann::json& axis);
/// The same with velocity and torque: "axis x: ContinuousMotion at 90 deg, 30 deg/s, 0.5 Nm".
[[nodiscard]] std::string motion_line(const nlohmann::json& axis);
/// "axis x: recorded 90 deg": the position of the last event of its touch probe.
[[nodiscard]] std::string recorded_line(const nlohmann::json& axis);

}  // namespace driveline::cli
