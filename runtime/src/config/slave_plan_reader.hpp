#pragma once

#include "driveline/runtime/config/slave_plan_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the keys of SlavePlanConfig from a [[slave]] table; the caller reads its other keys. Throws ConfigError.
[[nodiscard]] SlavePlanConfig read_slave_plan(TomlReader& slave);

}  // namespace driveline::runtime
