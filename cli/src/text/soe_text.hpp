#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/ecat_master/soe/soe_parameter.hpp"
#include "driveline/wire/soe.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// "S-0-0017".
[[nodiscard]] std::string idn_text(wire::Idn idn);

/// The value as its attribute wants it shown, a list in brackets; conversion factor and decimals are not applied. Bytes
/// in hexadecimal when their number does not fit.
[[nodiscard]] std::string soe_value_text(std::span<const std::byte> value, const wire::SoeAttribute& attribute);
/// The same as numbers, strings and arrays.
[[nodiscard]] nlohmann::json soe_value_json(std::span<const std::byte> value, const wire::SoeAttribute& attribute);
/// A value as it is written on the command line, the elements of a list separated by commas. Failure: status 2.
[[nodiscard]] Outcome<std::vector<std::byte>> parse_soe_value(std::string_view text,
                                                              const wire::SoeAttribute& attribute);

/// Everything about an operation datum, a line for each element.
[[nodiscard]] std::string soe_parameter_text(wire::Idn idn, const ecat_master::SoeParameter& parameter);
/// Number, name, value and unit in one line, without its end.
[[nodiscard]] std::string soe_line_text(wire::Idn idn, const ecat_master::SoeParameter& parameter);
/// All of it as an object; `null` for what it does not have.
[[nodiscard]] nlohmann::json soe_parameter_json(wire::Idn idn, const ecat_master::SoeParameter& parameter);

}  // namespace driveline::cli
