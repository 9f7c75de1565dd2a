#include "units.hpp"

#include <algorithm>
#include <array>
#include <numbers>

namespace driveline::bridge::clients {
namespace {

constexpr std::array kUnits{DisplayUnit{"rad", false, 1},
                            DisplayUnit{"deg", false, std::numbers::pi / 180},
                            DisplayUnit{"rev", false, 2 * std::numbers::pi},
                            DisplayUnit{"m", true, 1},
                            DisplayUnit{"mm", true, 1e-3},
                            DisplayUnit{"um", true, 1e-6}};

}  // namespace

bool DisplayUnits::add(std::string_view text) {
  const auto equals = text.rfind('=');
  if (equals == std::string_view::npos || equals == 0) return false;
  const auto* const unit = std::find_if(kUnits.begin(), kUnits.end(),
                                        [&](const auto& known) { return known.name == text.substr(equals + 1); });
  if (unit == kUnits.end()) return false;
  units_[std::string(text.substr(0, equals))] = unit;
  return true;
}

const DisplayUnit& DisplayUnits::of(const std::string& axis, bool linear) const {
  const auto found = units_.find(axis);
  if (found != units_.end() && found->second->linear == linear) return *found->second;
  return *std::find_if(kUnits.begin(), kUnits.end(), [&](const auto& known) { return known.linear == linear; });
}

}  // namespace driveline::bridge::clients
