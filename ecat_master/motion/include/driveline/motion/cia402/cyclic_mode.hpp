#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "driveline/motion/cia402/cia402.hpp"

namespace driveline::motion::cia402 {

/// The modes in which an axis follows the master's setpoints.
inline constexpr std::array kCyclicModes{Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque};

/// The bit of a mode in object 6502h, supported drive modes: bit 0 is mode 1, and so on (CiA 402-2). \rtsafe
[[nodiscard]] constexpr std::uint32_t mode_bit(Mode mode) noexcept {
  return std::uint32_t{1} << (static_cast<unsigned>(mode) - 1U);
}

/// Names of kCyclicModes, in that order: "csp", "csv", "cst".
[[nodiscard]] inline std::vector<std::string_view> cyclic_mode_names() {
  std::vector<std::string_view> names;
  for (const auto mode : kCyclicModes) names.push_back(to_text(mode));
  return names;
}

/// The cyclic mode with this name; none: no cyclic mode has it.
[[nodiscard]] inline std::optional<Mode> find_cyclic_mode(std::string_view name) noexcept {
  const auto* found =
      std::find_if(kCyclicModes.begin(), kCyclicModes.end(), [name](Mode mode) { return to_text(mode) == name; });
  if (found == kCyclicModes.end()) return std::nullopt;
  return *found;
}

}  // namespace driveline::motion::cia402
