#pragma once

#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/slaves/signal.hpp"

namespace driveline::runtime {

/// Reads the signal of an input over time: shape with value, low, high, period_s, or at_ms and values. All kinds of
/// devices use the same keys. Throws ConfigError.
[[nodiscard]] slaves::Signal read_signal(TomlReader& reader);

}  // namespace driveline::runtime
