#pragma once

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads [process_data], [[group]] and [[copy]] of a line whose slaves and axes have been read:
///
///   [process_data]   layout = "overlapped", "sequential" or "lrd_lwr"
///   [[group]]        name, slaves = ["x", ...], divider, phase, zero_outputs_after
///   [[copy]]         from = "slave.object", to = "slave.object"
///
/// Slaves that no group names form their own group, exchanged in every cycle. Throws ConfigError.
void read_process_data(TomlReader& root, LineConfig& config);

/// Reads [slave.names]: name = "object".
[[nodiscard]] std::vector<EntryName> read_entry_names(TomlReader reader);

}  // namespace driveline::runtime
