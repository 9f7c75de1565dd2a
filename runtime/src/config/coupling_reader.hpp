#pragma once

#include <filesystem>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Reads the tables [[encoder]], [[cam]] and [[coupling]] into LineConfig::couplings. Axes, path and stream have been
/// read; files are relative to `directory`.
void read_couplings(TomlReader& root, const std::filesystem::path& directory, LineConfig& config);

}  // namespace driveline::runtime
