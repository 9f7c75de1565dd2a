#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace driveline::cli {

/// Runs gnuplot on the file `script` inside `directory`. Error: a sentence (gnuplot is not there or failed, with what
/// it said last). Its warnings are not shown: they are about axes that did not move and the like.
[[nodiscard]] tl::expected<void, std::string> run_gnuplot(const std::filesystem::path& directory,
                                                          const std::string& script);

/// A name as a quoted string of a script. Names come from files and must not end the string and inject commands.
[[nodiscard]] std::string gnuplot_text(std::string_view name);

}  // namespace driveline::cli
