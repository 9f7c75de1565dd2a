#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// Returns the content of the file that `key` names. Throws a ConfigError for the key.
[[nodiscard]] std::string read_named_file(const TomlReader& reader, std::string_view key,
                                          const std::filesystem::path& file);

}  // namespace driveline::runtime
