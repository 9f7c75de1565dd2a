#include "axes/quantity.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/toml/suggestion.hpp"

namespace driveline::cli {
namespace {

/// A unit as it is written, and its factor to the SI unit.
struct NamedUnit {
  std::string name;
  double factor = 1.0;
};

std::string_view per(Quantity quantity) {
  switch (quantity) {
    case Quantity::kVelocity:
      return "/s";
    case Quantity::kAcceleration:
      return "/s^2";
    case Quantity::kJerk:
      return "/s^3";
    case Quantity::kPosition:
    case Quantity::kTorque:
    case Quantity::kTorqueRate:
      break;
  }
  return "";
}

/// The units that the quantity can have; the first one applies to a number without a unit.
std::vector<NamedUnit> units_of(const motion::AxisConfig& axis, Quantity quantity) {
  if (quantity == Quantity::kTorque) return {{axis.linear() ? "N" : "Nm"}};
  if (quantity == Quantity::kTorqueRate) return {{axis.linear() ? "N/s" : "Nm/s"}};
  const auto& own = motion::position_unit(axis);
  std::vector<NamedUnit> units{{fmt::format("{}{}", own.name, per(quantity)), own.to_si(1.0)}};
  for (const auto& unit : trajectory::position_units()) {
    if (unit.kind != axis.kind || unit.name == own.name) continue;
    units.push_back({fmt::format("{}{}", unit.name, per(quantity)), unit.to_si(1.0)});
  }
  if (quantity != Quantity::kVelocity) return units;
  constexpr double kMinute = 60.0;
  if (axis.linear()) {
    units.push_back({"m/min", 1.0 / kMinute});
  } else {
    units.push_back({"rpm", 2.0 * std::numbers::pi / kMinute});
  }
  return units;
}

std::vector<std::string_view> names_of(const std::vector<NamedUnit>& units) {
  std::vector<std::string_view> names;
  for (const auto& unit : units) names.emplace_back(unit.name);
  return names;
}

/// A hint for "1,5": a decimal comma; empty: the text has none.
std::string comma_hint(std::string_view text, std::string_view rest) {
  constexpr std::string_view kDigits = "0123456789";
  if (rest.size() < 2 || rest[0] != ',' || kDigits.find(rest[1]) == std::string_view::npos) return {};
  std::string meant(text);
  meant[meant.find(',')] = '.';
  return meant.find(',') == std::string::npos ? fmt::format("; did you mean {}?", meant) : std::string{};
}

}  // namespace

bool is_unit(const motion::AxisConfig& axis, std::string_view text) {
  constexpr std::array kAll{Quantity::kPosition, Quantity::kVelocity, Quantity::kAcceleration,
                            Quantity::kJerk,     Quantity::kTorque,   Quantity::kTorqueRate};
  return std::any_of(kAll.begin(), kAll.end(), [&](Quantity quantity) {
    const auto units = units_of(axis, quantity);
    return std::any_of(units.begin(), units.end(), [&](const NamedUnit& unit) { return unit.name == text; });
  });
}

std::optional<LeadingNumber> leading_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  LeadingNumber number;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number.value);
  if (error != std::errc{} || !std::isfinite(number.value)) return std::nullopt;
  number.rest = text.substr(static_cast<std::size_t>(end - text.data()));
  return number;
}

Outcome<double> parse_quantity(const motion::AxisConfig& axis, Quantity quantity, std::string_view text,
                               std::string_view what) {
  const auto units = units_of(axis, quantity);
  const auto number = leading_number(text);
  if (!number) return misused(fmt::format("{} \"{}\": a number is expected, as 10{}", what, text, units.front().name));
  auto unit = number->rest;
  while (unit.starts_with(' ')) unit.remove_prefix(1);
  if (unit.empty()) return number->value * units.front().factor;
  for (const auto& known : units) {
    if (known.name == unit) return number->value * known.factor;
  }
  if (const auto hint = comma_hint(text, number->rest); !hint.empty())
    return misused(fmt::format("{} \"{}\": a decimal point is expected{}", what, text, hint));
  const auto names = names_of(units);
  const auto meant = runtime::closest(unit, names);
  return misused(fmt::format("{} \"{}\": axis {} has no unit \"{}\" for it{}; {} {}", what, text, axis.name, unit,
                             meant.empty() ? "" : fmt::format(", did you mean {}?", meant), fmt::join(names, ", "),
                             names.size() > 1 ? "are possible" : "is expected"));
}

Outcome<std::chrono::nanoseconds> parse_time(std::string_view text, std::string_view what) {
  constexpr double kLongestSeconds = 1e7;
  const auto number = leading_number(text);
  std::optional<double> seconds;
  if (number && (number->rest.empty() || number->rest == "s")) seconds = number->value;
  if (number && number->rest == "ms") seconds = number->value / 1e3;
  if (!seconds || *seconds < 0.0 || *seconds > kLongestSeconds) {
    return misused(fmt::format("{} \"{}\": a time such as 2s or 500ms is expected, up to 10000000 s{}", what, text,
                               number ? comma_hint(text, number->rest) : std::string{}));
  }
  return std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double>(*seconds));
}

}  // namespace driveline::cli
