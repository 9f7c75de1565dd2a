#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace driveline::cli {

/// Runs gnuplot on the file `script` inside `directory`. Error: a sentence (gnuplot is not there or failed, with what
/// it said last). What it warns of is nothing to the user: an axis that did not move has a range of its own, and so on.
[[nodiscard]] tl::expected<void, std::string> run_gnuplot(const std::filesystem::path& directory,
                                                          const std::string& script);

/// A name as a text of a script, in quotes. Names come from files; none of them may end the text and go on as commands.
[[nodiscard]] std::string gnuplot_text(std::string_view name);

}  // namespace driveline::cli
