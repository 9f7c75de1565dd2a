#pragma once

#include "config/toml_reader.hpp"
#include "driveline/cli/slave_plan_config.hpp"

namespace driveline::cli {

/// Reads the keys of SlavePlanConfig out of a [[slave]] table; its other keys are the caller's. Throws ConfigErrors.
[[nodiscard]] SlavePlanConfig read_slave_plan(TomlReader& slave);

}  // namespace driveline::cli
