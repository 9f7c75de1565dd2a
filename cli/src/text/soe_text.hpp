#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/ecat_master/soe/soe_parameter.hpp"
#include "driveline/ecat_master/soe/soe_value.hpp"
#include "driveline/wire/soe.hpp"
#include "failure.hpp"

namespace driveline::cli {

using ecat_master::idn_text;
using ecat_master::soe_value_text;

/// The value of soe_value_text() as JSON numbers, strings and arrays.
[[nodiscard]] nlohmann::json soe_value_json(std::span<const std::byte> value, const wire::SoeAttribute& attribute);
/// Parses a value from the command line, elements of a list separated by commas. Failure: status 2.
[[nodiscard]] Outcome<std::vector<std::byte>> parse_soe_value(std::string_view text,
                                                              const wire::SoeAttribute& attribute);

/// All elements of an operation datum, one line each.
[[nodiscard]] std::string soe_parameter_text(wire::Idn idn, const ecat_master::SoeParameter& parameter);
/// Number, name, value and unit in one line, without a line end.
[[nodiscard]] std::string soe_line_text(wire::Idn idn, const ecat_master::SoeParameter& parameter);
/// All elements as a JSON object; `null` for missing ones.
[[nodiscard]] nlohmann::json soe_parameter_json(wire::Idn idn, const ecat_master::SoeParameter& parameter);

}  // namespace driveline::cli
