#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <filesystem>
#include <string_view>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"
#include "toml/toml_depth.hpp"

namespace driveline::runtime {

/// Longest text of a description: 256 slaves with 32 KiB each.
inline constexpr std::size_t kMaxDescriptionBytes = std::size_t{8} << 20;

/// Parses the text of a line description and calls `read(table)`, which returns the configuration. Errors of the text
/// and those that readers throw become the result. `name` is for errors.
template <typename Read>
auto read_description(std::string_view text, const std::filesystem::path& name, const Read& read)
    -> Result<decltype(read(toml::table()))> {
  if (text.size() > kMaxDescriptionBytes) {
    return fail_file(name,
                     fmt::format("is larger than {} MiB, the limit of a line description", kMaxDescriptionBytes >> 20));
  }
  if (const auto line = too_deep_line(text)) {
    return fail_file(
        name, fmt::format("keys or values are more than {} levels deep; a line description needs four", kMaxTomlDepth),
        *line);
  }
  try {
    return read(toml::parse(text, name.string()));
  } catch (const toml::parse_error& error) {
    return fail_file(name, std::string(error.description()), error.source().begin.line);
  } catch (const ConfigError& wrong) {
    return tl::unexpected(wrong.error);
  }
}

}  // namespace driveline::runtime
