#pragma once

#include <optional>
#include <span>
#include <string>

#include "line/line_view.hpp"

namespace driveline::cli {

/// A line description (TOML) of slaves that have been found; load_line_config() takes it as it is. Every slave is
/// expected by its identity, in the order of the line. `interface`: where the line is, nothing for a simulated one.
/// Failure: a slave whose EEPROM cannot be read has no identity to expect.
[[nodiscard]] Outcome<std::string> describe_line(std::span<const SlaveView> slaves,
                                                 const std::optional<std::string>& interface);

}  // namespace driveline::cli
