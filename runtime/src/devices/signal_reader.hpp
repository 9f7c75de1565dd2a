#pragma once

#include "driveline/runtime/toml/toml_reader.hpp"
#include "driveline/slaves/signal.hpp"

namespace driveline::runtime {

/// Reads how an input goes on: shape with value, low, high, period_s, or at_ms and values. The same keys for every
/// kind of device. Throws ConfigError.
[[nodiscard]] slaves::Signal read_signal(TomlReader& reader);

}  // namespace driveline::runtime
