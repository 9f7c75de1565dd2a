#pragma once

#include <filesystem>
#include <string>
#include <tl/expected.hpp>

namespace driveline::cli {

/// Runs gnuplot on the file `script` inside `directory`. Error: a sentence (gnuplot is not there or failed).
[[nodiscard]] tl::expected<void, std::string> run_gnuplot(const std::filesystem::path& directory,
                                                          const std::string& script);

}  // namespace driveline::cli
