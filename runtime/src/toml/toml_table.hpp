#pragma once

#include <toml++/toml.h>

#include <set>
#include <string>
#include <string_view>

#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// The table of a TomlReader, from a file that toml++ has read. Hidden from users of the library, who need no toml++.
struct TomlReader::Table {
  const toml::table* nodes;
  std::string file;
  std::string path;  ///< names the table in errors; empty for the root
  std::set<std::string, std::less<>> known{};

  [[nodiscard]] const toml::node* find(std::string_view key);
  [[nodiscard]] ConfigError error_at(const toml::node* node, std::string_view key, std::string reason) const;
  [[nodiscard]] std::string where(const toml::node* node, std::string_view key) const;
};

/// Returns a reader for the root of a file; `nodes` must outlive the reader.
[[nodiscard]] TomlReader read_toml_table(const toml::table& nodes, std::string file);

}  // namespace driveline::runtime
