#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "driveline/ecat_master/cia402/cia402.hpp"

namespace driveline::ecat_master::cia402 {

/// The modes in which an axis follows the master's setpoints.
inline constexpr std::array kCyclicModes{Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque};

/// Their names, in that order: "csp", "csv", "cst".
[[nodiscard]] inline std::vector<std::string_view> cyclic_mode_names() {
  std::vector<std::string_view> names;
  for (const auto mode : kCyclicModes) names.push_back(to_text(mode));
  return names;
}

/// The mode with that name; none: none of them has it.
[[nodiscard]] inline std::optional<Mode> find_cyclic_mode(std::string_view name) noexcept {
  const auto* found =
      std::find_if(kCyclicModes.begin(), kCyclicModes.end(), [name](Mode mode) { return to_text(mode) == name; });
  if (found == kCyclicModes.end()) return std::nullopt;
  return *found;
}

}  // namespace driveline::ecat_master::cia402
