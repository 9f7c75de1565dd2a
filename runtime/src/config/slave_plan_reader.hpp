#pragma once

#include "driveline/runtime/config/slave_plan_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the keys of SlavePlanConfig from a [[slave]] table; the caller reads its other keys. `device`: description of
/// the slave, with which [[slave.idn]] must agree; null: unknown. Throws ConfigError.
[[nodiscard]] SlavePlanConfig read_slave_plan(TomlReader& slave, const esi::DeviceDescription* device = nullptr);

/// Reads a [[slave.sdo]]. Throws ConfigError.
[[nodiscard]] motion::StartupSdo read_startup_sdo(TomlReader reader);

/// Reads a [[slave.idn]] of a slave with this description; null: unknown. Throws ConfigError.
[[nodiscard]] ecat_master::StartupIdn read_startup_idn(TomlReader reader, const esi::DeviceDescription* device);

/// Parses an entry of [[slave.pdo]] `entries`, "0x6040:0:16": index, sub-index, bits. Throws ConfigError.
[[nodiscard]] motion::MappedObject parse_pdo_entry(const TomlReader& reader, std::string_view text);

}  // namespace driveline::runtime
