#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "driveline/runtime/line.hpp"

namespace driveline::runtime {

/// The line described by `text`, on virtual time; `text` is stored as line.toml in `folder`, its output goes to the
/// folder out in there.
[[nodiscard]] inline Result<std::unique_ptr<Line>> virtual_line(const std::string& text,
                                                                const std::filesystem::path& folder) {
  const auto config = parse_line_config(text, folder / "line.toml");
  if (!config) return tl::unexpected(config.error());
  Line::Options options;
  options.virtual_time = true;
  options.adjust = [&folder](LineConfig& read) -> Result<void> {
    read.output.directory = folder / "out";
    return {};
  };
  return Line::from_config(*config, options);
}

}  // namespace driveline::runtime
