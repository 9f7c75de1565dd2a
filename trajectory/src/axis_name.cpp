#include "driveline/trajectory/axis_name.hpp"

#include <algorithm>

#include "text.hpp"

namespace driveline::trajectory {
namespace {

/// Reserved name of the time column.
constexpr std::string_view kTimeName = "time";

bool is_spelt_well(std::string_view name) {
  constexpr std::string_view kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.";
  return !name.empty() && name.size() <= kMaxAxisNameLength && name != kTimeName &&
         name.find_first_not_of(kAllowed) == std::string_view::npos;
}

char lower(char letter) {
  return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

bool is_alike_but_for_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace

std::string describe(const AxisNameError& error) {
  if (error.fault == AxisNameError::Fault::kTaken) {
    return "axis name " + in_quotes(error.name) + " appears twice";
  }
  return "axis name " + in_quotes(error.name) + " must be 1 to " + std::to_string(kMaxAxisNameLength) +
         " characters out of letters a to z and A to Z, digits and _-., and not be " + std::string(kTimeName);
}

tl::expected<void, AxisNameError> check_axis_name(std::string_view name, std::span<const std::string_view> taken) {
  using Fault = AxisNameError::Fault;
  if (!is_spelt_well(name)) {
    return tl::unexpected(AxisNameError{Fault::kSpelling, std::string(name)});
  }
  if (find_axis_name(name, taken)) {
    return tl::unexpected(AxisNameError{Fault::kTaken, std::string(name)});
  }
  return {};
}

std::optional<std::size_t> find_axis_name(std::string_view name, std::span<const std::string_view> names) noexcept {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(found - names.begin());
}

std::string axis_name_hint(std::string_view name, std::span<const std::string_view> names) {
  const auto alike =
      std::find_if(names.begin(), names.end(), [&](auto other) { return is_alike_but_for_case(name, other); });
  if (alike == names.end()) {
    return {};
  }
  return "; there is \"" + std::string(*alike) + "\", and upper and lower case differ";
}

}  // namespace driveline::trajectory
