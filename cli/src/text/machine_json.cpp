#include "text/machine_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

namespace driveline::cli {

using nlohmann::json;

tl::expected<trajectory::Machine, std::string> parse_machine(const json& machine) {
  if (!machine.is_object() || !machine.contains("type") || !machine["type"].is_string()) {
    return tl::unexpected(
        std::string("kinematics is an object with a type: \"cartesian\", \"scara\", \"delta\" or \"linear_delta\""));
  }
  std::vector<trajectory::MachineValue> values;
  for (const auto& [key, value] : machine.items()) {
    if (key == "type" || key == "unit") continue;
    if (value.is_boolean()) {
      values.push_back({key, value.get<bool>() ? 1.0 : 0.0, true});
    } else if (value.is_number()) {
      values.push_back({key, value.get<double>(), false});
    } else {
      return tl::unexpected(fmt::format("{} must be a number", key));
    }
  }
  const bool has_unit = machine.contains("unit") && machine["unit"].is_string();
  auto made = trajectory::Machine::make(machine["type"].get<std::string>(),
                                        has_unit ? machine["unit"].get<std::string>() : "", std::move(values));
  if (!made) return tl::unexpected(std::move(made.error().reason));
  return std::move(*made);
}

json to_json(const trajectory::Machine& machine) {
  json made = {{"type", machine.kind()}, {"unit", std::string(machine.unit().name)}};
  for (const auto& value : machine.values())
    made[value.name] = value.is_choice ? json(value.value != 0.0) : json(value.value);
  return made;
}

json to_json(const std::vector<runtime::events::EventAxis>& coordinates, const std::vector<double>& place) {
  auto made = json::array();
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const auto& unit = coordinates[i].unit;
    made.push_back({{"name", coordinates[i].name}, {"unit", std::string(unit.name)}});
    if (i < place.size()) made.back()["setpoint"] = unit.from_si(place[i]);
  }
  return made;
}

}  // namespace driveline::cli
