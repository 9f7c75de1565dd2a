#pragma once

#include "driveline/runtime/config/slave_plan_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the keys of SlavePlanConfig from a [[slave]] table; the caller reads its other keys. Throws ConfigError.
[[nodiscard]] SlavePlanConfig read_slave_plan(TomlReader& slave);

/// Reads a [[slave.sdo]]. Throws ConfigError.
[[nodiscard]] motion::StartupSdo read_startup_sdo(TomlReader reader);

/// Parses an entry of [[slave.pdo]] `entries`, "0x6040:0:16": index, sub-index, bits. Throws ConfigError.
[[nodiscard]] motion::MappedObject parse_pdo_entry(const TomlReader& reader, std::string_view text);

}  // namespace driveline::runtime
