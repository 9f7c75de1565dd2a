#include "toml/named_file.hpp"

#include <utility>

#include "driveline/runtime/files/input_file.hpp"

namespace driveline::runtime {

std::string read_named_file(const TomlReader& reader, std::string_view key, const std::filesystem::path& file) {
  auto text = read_input_file(file);
  if (!text) reader.fail(key, describe(text.error()));
  return std::move(*text);
}

}  // namespace driveline::runtime
