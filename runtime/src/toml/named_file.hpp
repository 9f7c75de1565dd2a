#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// The content of the file that `key` names. Throws a ConfigError that points at the key.
[[nodiscard]] std::string read_named_file(const TomlReader& reader, std::string_view key,
                                          const std::filesystem::path& file);

}  // namespace driveline::runtime
